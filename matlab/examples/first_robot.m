%% From a first robot to its range
% Run it from the folder matlab, after build_cppr; cells (%%) run step by step.

%% Two printed tubes of 150 mm
% A robot is a file, or its text. The notches of the leader open towards -Y, those of the follower towards +Y, so that their centroids lie
% on opposite sides: pulling the follower bends the robot.
file = strjoin({
    'name = "first"'
    'length_mm = 150'
    '[material]'
    'youngs_modulus_GPa = 5.39'
    'poissons_ratio = 0.35'
    'density_kg_m3 = 1240'
    '[[tube]]  # the leader'
    'outer_radius_mm = 4.5'
    'inner_radius_mm = 3.7'
    '[tube.notches]'
    'depth_mm = [8.2, 7.2]  # base and tip, linear between'
    'length_mm = 5'
    'tooth_mm = 5'
    '[[tube]]  # the follower'
    'outer_radius_mm = 3.2'
    'inner_radius_mm = 2.4'
    '[tube.notches]'
    'depth_mm = [5.6, 4.95]'
    'length_mm = 5'
    'tooth_mm = 5'
    'opening_deg = 0'
    'below_plate = "plain"'
    }', sprintf('\n'));
robot = cppr.Robot.fromText(file);

%% Pull the follower by 5 mm
% One solve gives shape, force and stability.
eq = robot.solve('pull', 5e-3);
fprintf('%s: tip at %.3f %.3f %.3f mm\n', eq.status, 1e3 * eq.tip_position);
fprintf('bent by %.1f degrees\n', acosd(eq.tip_rotation(1, 1)));
fprintf('pulled with %.3f N; margin to instability %.2f\n', eq.tension, eq.margin);

%% Turn it, load it, look at it
eq = robot.solve('pull', 5e-3, 'rotate', 20 * pi / 180, 'tip_force', [0 0 0.05]);
figure();
robot.plot(eq);
print('-dpng', 'first_robot.png');

%% A whole range at once
% The tip's path and the force while the follower is pushed and pulled.
pull = linspace(-8e-3, 8e-3, 161)';
many = robot.solveMany('pull', pull);
figure();
subplot(1, 2, 1);
plot(1e3 * many.tip_position(:, 1), 1e3 * many.tip_position(:, 2), 'k');
axis('equal');
ylim([-110 110]);
xlabel('tip x (mm)');
ylabel('tip y (mm)');
subplot(1, 2, 2);
plot(1e3 * pull, many.tension, 'k');
xlabel('pull (mm)');
ylabel('tension (N)');
print('-dpng', 'first_robot_range.png');
slope = gradient(many.tension, pull(2) - pull(1));
fprintf('stiffness of the actuator at rest %.3f N/mm\n', 1e-3 * slope(81));
