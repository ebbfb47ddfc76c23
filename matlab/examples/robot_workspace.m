%% Where the tip of a robot can go
% All combinations of pull and rotation of the prototype R1. Run it from the folder matlab, after build_cppr.

robot = cppr.Robot(fullfile('..', 'robots', 'r1.toml'));
many = robot.sweep('pull', linspace(-7e-3, 7e-3, 41), 'rotate', linspace(-pi, pi, 37), 'margin', true);
fprintf('%d poses: %d stable, %d unstable, %d without equilibrium\n', many.poses, sum(many.stable), sum(many.status == 1), ...
        sum(many.status == 2));
fprintf('smallest margin to instability of a stable pose %.3f\n', min(many.margin(many.stable)));

%% The tips, and the margin over both actuators
figure();
set(gcf(), 'PaperUnits', 'inches', 'PaperPosition', [0 0 12 4]);
tip = 1e3 * many.tip_position(many.stable, :);
subplot(1, 3, 1);
plot(tip(:, 1), tip(:, 2), 'k.', 'MarkerSize', 3);
axis('equal');
axis([60 170 -110 110]);
set(gca(), 'XTick', 80:40:160);
xlabel('x (mm)');
ylabel('y (mm)');
title('stable tips from the side');
subplot(1, 3, 2);
plot(tip(:, 3), tip(:, 2), 'k.', 'MarkerSize', 3);
axis('equal');
axis([-110 110 -110 110]);
set(gca(), 'XTick', -100:50:100);
xlabel('z (mm)');
ylabel('y (mm)');
title('from the front');
subplot(1, 3, 3);
margin = reshape(many.margin, many.grid);
margin(~reshape(many.stable, many.grid)) = NaN;
contourf(180 / pi * many.axis_values{2}, 1e3 * many.axis_values{1}, margin, 0:0.05:1);
colormap(flipud(gray(64)));
caxis([0.4 1]);
colorbar();
xlabel('rotation (deg)');
ylabel('pull (mm)');
title('margin to instability');
print('-dpng', 'robot_workspace.png');
