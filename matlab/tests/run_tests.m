function run_tests(program)
%RUN_TESTS  Checks cppr.Robot in MATLAB or Octave against the program cppr and against itself; errors where something is wrong.
%
%   run_tests('../target/release/cppr')    in the folder matlab, with that folder on the path

passed = 0;
robots = fullfile('..', 'robots');

    function expect(holds, what)
        if ~holds
            error('run_tests: %s', what);
        end
        passed = passed + 1;
    end

    function near(got, wanted, tolerance, what)
        if ~isequal(size(got), size(wanted)) || any(abs(got(:) - wanted(:)) > tolerance)
            error('run_tests: %s: %s instead of %s', what, mat2str(got, 8), mat2str(wanted, 8));
        end
        passed = passed + 1;
    end

    function refuses(action, identifier, part)
        try
            action();
        catch problem
            expect(strcmp(problem.identifier, identifier), sprintf('%s, not %s: %s', problem.identifier, identifier, problem.message));
            expect(~isempty(strfind(problem.message, part)), sprintf('"%s" lacks "%s"', problem.message, part));
            return
        end
        error('run_tests: not refused: %s', part);
    end

% What the program prints for the same command.
folder = tempname();
mkdir(folder);
json = fullfile(folder, 'r.json');
asked = ' --pull 2=1mm --pull 3=-0.5mm --rotate 2=30deg --tip-force 0,0,-0.1N --json ';
[failed, text] = system(['"' program '" solve ' fullfile(robots, 'childs3.toml') asked '"' json '"']);
expect(~failed, text);
result = jsondecode(fileread(json));
delete(json);
rmdir(folder);
robot = cppr.Robot(fullfile(robots, 'childs3.toml'));
expect(strcmp(robot.name, 'Childs3') && robot.tubes == 3 && isequal(robot.actuated, [2 3]) && robot.length == 0.03, 'the robot');
eq = robot.solve('pull', {2, 1e-3, 3, -0.5e-3}, 'rotate', pi / 6, 'tip_force', [0 0 -0.1]);
expect(eq.stable && strcmp(eq.status, 'converged'), 'status');
near(eq.tip_position, result.tip_position_m, 1e-9, 'tip of the program');
near(eq.tension, [result.actuators.tension_N], 1e-7, 'tensions of the program');
near(eq.torque, [result.actuators.torque_Nm], 1e-9, 'torques of the program');
near(eq.pull, [1e-3 -0.5e-3], 1e-15, 'pulls');
near(eq.rotation, [pi / 6, 0], 1e-12, 'rotations');
near(eq.tip_rotation' * eq.tip_rotation, eye(3), 1e-12, 'rotation of the tip');
expect(det(eq.tip_rotation) > 0.999, 'rotation of the tip');
accuracy = result.accuracy;
near(eq.error, [accuracy.tip_m accuracy.force_N accuracy.torque_Nm]', 1e-10, 'error of the program');
near(eq.shape.centre(end, :)', eq.tip_position, 1e-12, 'end of the shape');
near(eq.shape.rotation(:, :, end), eq.tip_rotation, 1e-12, 'end of the shape');
expect(isequal(size(eq.shape.centroid), [51 3 3]) && isequal(size(eq.shape.moment), [51 3 3]), 'sizes of the shape');
near(sqrt(sum((eq.shape.centroid(end, :, 2)' - eq.tip_position) .^ 2)), 0.983e-3, 1e-9, 'centroid of tube 2 at the tip');

% Derivatives against differences.
expect(isequal(eq.inputs, {'pull 2', 'rotate 2', 'pull 3', 'rotate 3'}), 'inputs');
step = 1e-6;
tip = @(p, r, f) getfield(robot.solve('pull', {2, 1e-3, 3, -0.5e-3 + p}, 'rotate', {2, pi / 6, 3, r}, 'tip_force', [0 f -0.1], ...
                                      'sections', 0), 'tip_position');
near(eq.jacobian(1:3, 3), (tip(step, 0, 0) - tip(-step, 0, 0)) / (2 * step), 1e-5, 'Jacobian by a pull');
near(eq.jacobian(1:3, 4), (tip(0, step, 0) - tip(0, -step, 0)) / (2 * step), 1e-7, 'Jacobian by a rotation');
near(eq.compliance(1:3, 2), (tip(0, 0, 1e-4) - tip(0, 0, -1e-4)) / 2e-4, 1e-6, 'compliance');
near(eq.response, eq.response', 1e-8 * max(abs(eq.response(:))), 'symmetry of the response');
[J, same] = robot.jacobian('pull', {2, 1e-3, 3, -0.5e-3}, 'rotate', pi / 6, 'tip_force', [0 0 -0.1]);
near(J, eq.jacobian, 1e-9, 'jacobian');
expect(~isfield(same, 'shape') && ~isfield(same, 'margin') && ~isfield(same, 'error'), 'jacobian leaves out what it does not need');

% A warm start ends where a cold one does, in fewer steps.
warm = robot.solve('pull', {2, 1.001e-3, 3, -0.5e-3}, 'rotate', pi / 6, 'tip_force', [0 0 -0.1], 'warm', true);
cold = robot.solve('pull', {2, 1.001e-3, 3, -0.5e-3}, 'rotate', pi / 6, 'tip_force', [0 0 -0.1]);
near(warm.tip_position, cold.tip_position, 1e-10, 'warm start');
expect(warm.iterations < cold.iterations, 'a warm start takes fewer steps');

% Force instead of motion gives the motion back.
driven = robot.solve('tension', {2, eq.tension(1), 3, eq.tension(2)}, 'torque', {2, eq.torque(1), 3, eq.torque(2)}, ...
                     'tip_force', [0 0 -0.1]);
near(driven.pull, eq.pull, 1e-8, 'motions from efforts');

% Options and loads; what was given before is forgotten.
r1 = cppr.Robot(fullfile(robots, 'r1.toml'));
free = r1.solve('pull', 2e-3);
loads = {cppr.wrench([0 0.05 0], 'at', 0.06, 'frame', 'section'), cppr.distributed([0 0 0.2], 0, 0.1), cppr.gravity([0 -9.81 0]), ...
         cppr.thread(0.1, [0.2 0.1 0], 'radius', 0.01)};
loaded = r1.solve('pull', 2e-3, 'loads', loads);
expect(abs(loaded.tip_position(3)) > 1e-4, 'loads move the tip');
again = r1.solve('pull', 2e-3);
near(again.tip_position, free.tip_position, 1e-11, 'loads do not stay');
near(getfield(r1.solve('pull', 2e-3, 'planar', true), 'tip_position'), free.tip_position, 1e-4, 'planar');
r4 = cppr.Robot(fullfile(robots, 'r4.toml'));
near(getfield(r4.solve('pull', 11e-3, 'planar', true, 'printed', true), 'tension'), 3.777, 5e-3, 'printed formulation');
near(getfield(r4.solve('pull', 11e-3), 'tension'), 5.040, 5e-3, 'options do not stay');

% Many poses are single ones; a grid is all combinations.
pull = linspace(-2e-3, 2e-3, 30)';
force = [zeros(30, 1), linspace(0, 0.05, 30)', zeros(30, 1)];
many = r1.solveMany('pull', pull, 'tip_force', force, 'rotate', 0.2, 'jacobian', true, 'margin', true);
near(many.status, zeros(30, 1), 0, 'status of many');
for k = [1 17 30]
    single = r1.solve('pull', pull(k), 'tip_force', force(k, :), 'rotate', 0.2);
    near(many.tip_position(k, :)', single.tip_position, 1e-9, 'tip of many');
    near(many.tip_rotation(:, :, k), single.tip_rotation, 1e-9, 'rotation of many');
    near(many.tension(k), single.tension, 1e-7, 'tension of many');
    near(many.jacobian(:, :, k), single.jacobian, 1e-7, 'jacobian of many');
    near(many.compliance(:, :, k), single.compliance, 1e-7, 'compliance of many');
    near(many.margin(k), single.margin, 1e-7, 'margin of many');
end
next = r1.solveMany('pull', pull, 'tip_force', force, 'rotate', 0.2, 'start', 'neighbour', 'threads', 1);
near(next.tip_position, many.tip_position, 1e-9, 'from the neighbour');
sweep = robot.sweep('pull', {2, [0 1e-3 1.5e-3], 3, [-5e-4 0]}, 'rotate', 0.3);
expect(isequal(sweep.axes, {'pull 2', 'pull 3'}) && isequal(sweep.grid, [3 2]) && sweep.poses == 6, 'grid of a sweep');
single = robot.solve('pull', {2, 1.5e-3, 3, 0}, 'rotate', 0.3);
near(sweep.tip_position(6, :)', single.tip_position, 1e-9, 'last point of a sweep');
near(sweep.pull(3, :), [1.5e-3 -5e-4], 1e-12, 'third point of a sweep');
far = r1.solveMany('pull', [1e-3; 0.149]);
expect(far.status(2) == 2 && all(isnan(far.tip_position(2, :))) && far.stable(1) && ~far.stable(2), 'a pose that is none');

% A robot of parts and joints, against the program.
parts = cppr.Robot(fullfile(robots, 'bundles', 'two_sections.toml'));
expect(parts.hasParts && ~robot.hasParts && isequal(parts.actuated, 1:4), 'a robot of parts');
folder = tempname();
mkdir(folder);
json = fullfile(folder, 'r.json');
asked = ' --pull 2=3mm --pull 4=2mm --rotate 4=20deg --tip-force 0,0,0.02N --json ';
[failed, text] = system(['"' program '" solve ' fullfile(robots, 'bundles', 'two_sections.toml') asked '"' json '"']);
expect(~failed, text);
result = jsondecode(fileread(json));
delete(json);
rmdir(folder);
eq = parts.solve('pull', {2, 3e-3, 4, 2e-3}, 'rotate', {4, pi / 9}, 'tip_force', [0 0 0.02]);
expect(eq.stable && strcmp(eq.status, 'converged') && isequal(eq.tubes, 1:4), 'status of a robot of parts');
near(eq.tip_position, result.tip_position_m, 1e-12, 'tip of the program');
near(eq.tension, [result.actuators.tension_N], 1e-9, 'tensions of the program');
near(eq.torque, [result.actuators.torque_Nm], 1e-11, 'torques of the program');
expect(isequal(eq.inputs(1:3), {'pull 1', 'rotate 1', 'pull 2'}) && isequal(size(eq.jacobian), [6 8]), 'inputs of a robot of parts');
tip = @(p) getfield(parts.solve('pull', {2, 3e-3, 4, 2e-3 + p}, 'rotate', {4, pi / 9}, 'tip_force', [0 0 0.02], 'sections', 0), 'tip_position');
near(eq.jacobian(1:3, 7), (tip(1e-5) - tip(-1e-5)) / 2e-5, 1e-3, 'Jacobian of a robot of parts');
expect(max(abs(eq.jacobian(1:3, 7))) > 1, 'Jacobian of a robot of parts');
eq = parts.solve('pull', {2, 3e-3, 4, 2e-3}, 'rotate', {4, pi / 9}, 'tip_force', [0 0 0.02], 'warm', true);
near(eq.tip_position, result.tip_position_m, 1e-9, 'warm start of a robot of parts');
near(eq.shape.centre(end, :)', eq.tip_position, 1e-9, 'end of the shape of a robot of parts');
expect(isnan(eq.margin) && isnan(eq.shape.abscissa(end, 1)) && abs(eq.shape.abscissa(1, 2) - 3e-3) < 1e-12, 'what parts have');
many = parts.solveMany('pull', {2, linspace(1e-3, 3e-3, 20)', 4, 2e-3}, 'rotate', {4, pi / 9}, 'tip_force', [0 0 0.02], 'start', 'neighbour');
near(many.tip_position(20, :)', result.tip_position_m, 1e-9, 'the last of many');
refuses(@() parts.solve('refine', 2), 'cppr:argument', 'only the stretch');
refuses(@() parts.solve('pull', 1), 'cppr:command', 'behind the plate');

% Sudden changes are integrated, said, and left to modes where that is asked; the right tip is that of the program's tests.
tube = @(outer, inner, depth, opening) sprintf(['[[tube]]\nouter_radius_mm = %g\ninner_radius_mm = %g\n[tube.notches]\nlength_mm = 0.5\n' ...
    'tooth_mm = 0.3\nopening_deg = %g\ndepth_mm = { x_mm = [0, 30, 30.01, 110, 110.01, 115], depth_mm = [0, 0, %g, %g, 0, 0] }\n'], ...
    outer, inner, opening, depth, depth);
text = [sprintf('name = "steps"\nlength_mm = 115\n[material]\nyoungs_modulus_GPa = 60\npoissons_ratio = 0.3\ndensity_kg_m3 = 6450\n'), tube(1, 0.9, 1.6, 180), tube(0.8, 0.7, 1.3, 0)];
lastwarn('', '');
steps = cppr.Robot.fromText(text);
[said, identifier] = lastwarn();
expect(strcmp(identifier, 'cppr:integrated') && ~isempty(strfind(said, 'notch depth of tube 1 at 30 mm')), 'sudden changes are said');
expect(steps.hasParts && ~isempty(strfind(steps.suddenChanges, 'tube 2')) && isempty(r1.suddenChanges), 'sudden changes');
eq = steps.solve('pull', 2e-3);
near(eq.tip_position, [88.599e-3 -50.173e-3 0]', 2e-5, 'tip of a robot with sudden changes');
near(eq.tension(2), 1.8538, 1e-3, 'force of a robot with sudden changes');
modes = steps.withModes();
expect(~modes.hasParts && isempty(modes.suddenChanges), 'a robot with modes');
lastwarn('', '');
eq = modes.solve('pull', 2e-3);
[said, identifier] = lastwarn();
expect(strcmp(identifier, 'cppr:error') && eq.error(1) > 1e-4 * 0.115, 'what the modes leave out is said');
refuses(@() parts.withModes(), 'cppr:robot', 'has no modes');

% As many modes as the accuracy needs, from rest; a loop takes them where it asks for them.
deeper = regexprep(fileread(fullfile(robots, 'r1.toml')), 'depth_mm = 5.0', 'depth_mm = [5, 5, 5, 5, 5, 5, 5, 5.3, 5, 5, 5, 5, 5, 5, 5]', 'once');
deeper = cppr.Robot.fromText(deeper);
eq = deeper.solve('pull', 5e-3);
usual = deeper.solve('pull', 5e-3, 'accuracy', 0);
expect(eq.error(1) < 0.5 * usual.error(1) && usual.error(1) > 1e-4 * 0.15, 'as many modes as the accuracy needs');
kept = deeper.solve('pull', 5e-3, 'refine', 1);
near(kept.tip_position, usual.tip_position, 1e-9, 'modes that are chosen stay');
deeper.solve('pull', 5e-3);
near(getfield(deeper.solve('pull', 5e-3, 'warm', true, 'accuracy', 1e-4), 'tip_position'), eq.tip_position, 1e-9, 'a loop that asks for the accuracy');
near(getfield(deeper.solve('pull', 5e-3, 'warm', true), 'tip_position'), usual.tip_position, 1e-9, 'a loop that does not');
many = deeper.solveMany('pull', [4e-3; 5e-3], 'accuracy', 1e-4);
near(many.tip_position(2, :)', eq.tip_position, 1e-9, 'many with as many modes as they need');
expect(deeper.fewestModes('pull', [0; 5e-3]) > 1 && deeper.fewestModes('pull', 5e-3, 'accuracy', 0.1) < 1, 'as few modes as poses need');

% As few modes as a loop bears with.
bare = cppr.Robot.fromText(sprintf(['name = "rod"\nlength_mm = 200\n[material]\nyoungs_modulus_GPa = 60\npoissons_ratio = 0.3\ndensity_kg_m3 = 6450\n' ...
    '[[tube]]\nouter_radius_mm = 1\ninner_radius_mm = 0.8\n']));
refine = bare.fewestModes('tip_force', [0 0.2 0; 0 0 0.2]);
expect(refine == 0.375, 'as few modes as a rod needs');
eq = bare.solve('tip_force', [0 0.2 0], 'refine', refine);
whole = bare.solve('tip_force', [0 0.2 0]);
near(eq.tip_position, whole.tip_position, 1e-4 * 0.2, 'the tip with few modes');
expect(any(eq.tip_position ~= whole.tip_position), 'few modes are other modes');
refuses(@() bare.solve('refine', 1.5), 'cppr:argument', 'cannot be 1.5');
refuses(@() parts.fewestModes('pull', [0; 1e-3]), 'cppr:argument', 'no modes');
refuses(@() bare.solve('loop_tolerance', 1e-6), 'cppr:argument', 'nothing is integrated');
% A loop of a robot of parts integrates as coarsely as it is told.
curve = cppr.Robot(fullfile(robots, 'bundles', 's_shape.toml'));
ends = cell(1, 2);
for k = 1:2
    curve.solve('pull', 2e-3);
    tolerance = [1e-8, 1e-6];
    for pull = 2e-3 + 2e-5 * (1:10)
        ends{k} = curve.solve('pull', pull, 'warm', true, 'loop_tolerance', tolerance(k));
    end
end
away = norm(ends{1}.tip_position - ends{2}.tip_position);
expect(away > 1e-10 && away < 1e-5 * curve.length, 'a loop of a robot of parts');

% A figure of each kind.
figure('visible', 'off');
handles = r1.plot(free);
expect(numel(handles) == 3, 'lines of a figure in the plane');
drawn = get(handles(3), 'XData');
near(drawn(end), 1e3 * free.tip_position(1), 1e-9, 'a figure is in mm');
eq = robot.solve('pull', 1e-3, 'rotate', 0.5);
expect(numel(robot.plot(eq, 'r')) == 4, 'lines of a figure in space');
expect(numel(parts.plot(parts.solve('pull', 3e-3))) == 5, 'lines of a figure of parts');
close('all');

% What is wrong is said.
refuses(@() cppr.Robot('no such file'), 'cppr:robot', 'the file cannot be read');
refuses(@() cppr.Robot.fromText('length_mm = -1'), 'cppr:robot', 'line 1');
refuses(@() robot.solve('pull', {1, 1e-3}), 'cppr:command', 'tube 1 is the leader');
refuses(@() robot.solve('pull', {4, 1e-3}), 'cppr:command', 'there is no tube 4');
refuses(@() robot.solve('pull', 5), 'cppr:command', 'Check the unit');
refuses(@() robot.solve('pull', NaN), 'cppr:command', 'not finite');
refuses(@() robot.solve('pull', 1e-3, 'tension', 1), 'cppr:command', 'given twice');
refuses(@() robot.solve('pul', 1e-3), 'cppr:argument', 'there is no ''pul''');
refuses(@() robot.solve('pull'), 'cppr:argument', 'pairs of a name and a value');
refuses(@() robot.solve('pull', [1 2] * 1e-3), 'cppr:argument', 'solveMany takes many');
refuses(@() robot.solve('tip_force', [0 1]), 'cppr:argument', 'three numbers');
refuses(@() robot.solve('loads', {3}), 'cppr:argument', 'cppr.wrench');
refuses(@() robot.solve('refine', 9), 'cppr:argument', 'cannot be 9');
refuses(@() robot.solveMany('pull', [0; 1e-3], 'rotate', [0; 1; 2]), 'cppr:argument', 'give as many for each');
refuses(@() robot.solveMany('pull', [0; NaN]), 'cppr:command', 'pose 1');
refuses(@() robot.sweep('pull', 1e-3), 'cppr:argument', 'more than one value');
refuses(@() robot.shape(0.05), 'cppr:argument', 'reaches from 0 to 0.03 m');
refuses(@() r1.solve('pull', 0.149), 'cppr:noEquilibrium', 'not converged');
refuses(@() cppr_mex('get', 99, 1), 'cppr:argument', 'has been closed');
lastwarn('', '');
robot.solve('rotate', 90);
[text, identifier] = lastwarn();
expect(strcmp(identifier, 'cppr:unit') && ~isempty(strfind(text, 'Check number and unit')), 'a doubtful unit is warned of');

fprintf('%d passed, 0 failed\n', passed);
end
