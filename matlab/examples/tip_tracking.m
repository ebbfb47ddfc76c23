%% Closed-loop tracking of a circle with the tip
% The controller knows a model, the "real" robot differs from it: its tubes are a fifth stiffer or softer and a force that nobody told the
% controller pulls at its tip. Run it from the folder matlab, after build_cppr.

rate = 200;      % Hz
period = 2;      % s for one turn of the circle
radius = 5e-3;   % m
gain = 20;       % 1/s

path = fullfile('..', 'robots', 'childs3.toml');
model = cppr.Robot(path);
text = fileread(path);
% The stiffness of each tube stands on a line of its own.
parts = regexp(text, 'bending_z_Nmm2 = ', 'split');
factor = [1.2 0.8 1.2];
text = parts{1};
for tube = 1:3
    [value, rest] = strtok(parts{tube + 1}, sprintf('\n'));
    text = [text, sprintf('bending_z_Nmm2 = %.6g', factor(tube) * str2double(value)), rest];
end
real = cppr.Robot.fromText(text);
disturbance = [0 0.02 -0.03];   % N

%% Resolved rates
% In every cycle the controller measures the tip, solves its model where the motors stand, starting at the last equilibrium, and turns the
% error into motor speeds with the Jacobian of the two translations. Its part of the cycle is timed; the simulated robot's is not.
steps = period * rate;
dt = 1 / rate;
phase = 2 * pi * (0:steps - 1)' / steps;
wanted = radius * [cos(phase), sin(phase)];
speed = [gradient(wanted(:, 1), dt), gradient(wanted(:, 2), dt)];
motors = [0; 0];
cost = zeros(steps, 1);
reached = zeros(steps, 2);
for k = 1:steps
    body = real.solve('pull', {2, motors(1), 3, motors(2)}, 'tip_force', disturbance, 'warm', true, 'sections', 0, 'margin', false);
    tip = body.tip_position(2:3);
    start = tic;
    J = model.jacobian('pull', {2, motors(1), 3, motors(2)}, 'warm', true);
    motors = motors + dt * (J(2:3, [1 3]) \ (speed(k, :)' + gain * (wanted(k, :)' - tip)));
    cost(k) = toc(start);
    reached(k, :) = tip';
end

%%
distance = sqrt(sum((reached - wanted) .^ 2, 2));
settled = distance(floor(steps / 4) + 1:end);
fprintf('tracking at %d Hz: error %.3f mm at most after a quarter turn\n', rate, 1e3 * max(settled));
fprintf('the controller takes %.1f ms per cycle; late cycles: %.1f %%\n', 1e3 * median(cost), 100 * mean(cost > dt));
figure();
plot(1e3 * wanted(:, 1), 1e3 * wanted(:, 2), 'Color', [0.6 0.6 0.6]);
hold('on');
plot(1e3 * reached(:, 1), 1e3 * reached(:, 2), 'k--');
axis('equal');
xlabel('y (mm)');
ylabel('z (mm)');
legend('wanted', 'tip', 'Location', 'northeastoutside');
print('-dpng', 'tip_tracking.png');
