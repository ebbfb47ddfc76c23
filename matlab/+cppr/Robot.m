classdef Robot < handle
%CPPR.ROBOT  A concentric push-pull robot: nested, notched tubes, joined at the tip, that bend when one is pushed or pulled in another.
%
%   robot = cppr.Robot('robots/r3.toml')       from a robot file, of parts and joints too
%   robot = cppr.Robot.fromText(text)          from the text of one
%
%   eq   = robot.solve('pull', 5e-3)           the equilibrium under a command
%   J    = robot.jacobian('pull', 5e-3)        how the tip answers to the actuators there
%   many = robot.solveMany('pull', P)          many poses at once, on all cores
%   many = robot.sweep('pull', p, 'rotate', r) all combinations
%   robot.plot(eq)                             a figure
%   shape = robot.shape(x)                     fields along the robot
%
%   Plain SI throughout: m, rad, N, N m. The base frame has its origin at the centre of the baseplate, X along the robot at rest. Tubes are
%   numbered from 1 as in the robot file; a number alone belongs to tube 2, the first follower, and {2, a, 3, b} names tubes. What is not
%   prescribed is held. In a robot of parts and joints tube 1 can be driven too.
%
%   Tubes with sudden changes along them, which modes do not follow, are integrated as parts and joints are: the warning cppr:integrated says so, and
%   robot.withModes() gives the robot with modes.
%
%   Errors: cppr:robot (the file), cppr:command (what cannot be asked), cppr:noEquilibrium, cppr:argument. Warnings: cppr:unit, cppr:error,
%   cppr:integrated.
%
%   Help on each: help cppr.Robot.solve and so on.

    properties (SetAccess = private)
        name = '';       % Name of the robot.
        length = NaN;    % Rest length, of parts and joints that of the longest tube (m).
        tubes = 0;       % Number of tubes.
        actuated = [];   % Numbers of the tubes that have actuators.
        isPlanar = false; % True where all centroid lines at rest lie in the X-Y plane.
        hasParts = false; % True for a robot of parts and joints, and for one with sudden changes.
        suddenChanges = ''; % Where sudden changes are for which it is integrated; empty for other robots.
    end

    properties (Access = private)
        id = 0;
        number;      % Numbers of the enumerators of the library.
        inputs = {}; % Columns of the Jacobian: translation and rotation of every tube with an actuator,
        places = []; % and where they stand among those of all tubes.
    end

    methods
        function robot = Robot(source, kind)
        %ROBOT  Reads a robot file. `kind`: 1 where `source` is its text, 2 where it is the number of an open robot.
            if nargin < 1
                error('cppr:argument', 'give the path of a robot file, as in cppr.Robot(''robots/r3.toml'')');
            end
            if exist('cppr_mex', 'file') ~= 3
                error('cppr:build', 'cppr_mex is not built or not on the path: run build_cppr in the folder matlab');
            end
            robot.number = cppr_mex('numbers');
            if nargin < 2
                kind = 0;
            end
            if kind == 2
                robot.id = source;
            else
                robot.id = cppr_mex('open', cppr.Robot.utf8(source), double(kind == 0));
            end
            info = cppr_mex('info', robot.id);
            robot.suddenChanges = cppr.Robot.text(info.sudden);
            if ~isempty(robot.suddenChanges)
                warning('cppr:integrated', 'modes do not follow sudden changes (%s): integrated along the robot; withModes() keeps the modes', ...
                        robot.suddenChanges);
            end
            robot.name = cppr.Robot.text(info.name);
            robot.length = info.length;
            robot.tubes = numel(info.actuated);
            robot.actuated = find(info.actuated);
            robot.isPlanar = info.planar ~= 0;
            robot.hasParts = info.parts ~= 0;
            for tube = robot.actuated
                robot.inputs = [robot.inputs, {sprintf('pull %d', tube), sprintf('rotate %d', tube)}];
                robot.places = [robot.places, 2 * tube - 1, 2 * tube];
            end
        end

        function delete(robot)
            if robot.id > 0
                cppr_mex('close', robot.id);
                robot.id = 0;
            end
        end

        function other = withModes(robot)
        %WITHMODES  The robot of the same file with modes, which do not follow its sudden changes: faster, less exact, with all options.
            other = cppr.Robot(cppr_mex('with_modes', robot.id), 2);
        end

        function eq = solve(robot, varargin)
        %SOLVE  The equilibrium under a command.
        %
        %   eq = robot.solve('pull', 5e-3, 'tip_force', [0 0 0.05])
        %   eq = robot.solve('pull', {2, 1e-3, 3, -0.5e-3}, 'rotate', {2, pi/6})
        %
        %   'pull'        translation of a tube (m), pull positive, push negative
        %   'tension'     or the force that pulls it (N)
        %   'rotate'      rotation of a tube (rad), right-handed about +X
        %   'torque'      or the torque that turns it (N m)
        %   'tip_force'   dead force on the tip (N), [x y z] in the base frame
        %   'tip_moment'  dead moment on the tip (N m)
        %   'loads'       cell array of cppr.wrench, cppr.distributed, cppr.gravity, cppr.thread
        %   'warm'        true: start at the last equilibrium of this robot, for loops. Default false: from rest
        %   'sections'    number of sections of eq.shape; default 51, 0 for none
        %   'margin'      false leaves the margin to instability out; default true
        %   'error'       false leaves the error of the modes out, which takes milliseconds; default true, false where 'warm' is true
        %   'planar', 'stretch', 'printed', 'relative_angle'   true or false; default false
        %   'refine'      modes and nodes multiplied, 1 to 8, or 0.375, 0.5 or 0.75 (see fewestModes); 'tolerance' of the residual, 1e-11
        %   'loop_tolerance'   of a robot of parts and joints: error that a step of its integration may make where 'warm' is true, as a part of the length, at most
        %                 1e-4. 1e-6 takes up to half the time of the default, 1e-8
        %   'accuracy'    error of the tip that is accepted, as a part of the length: where the modes exceed it, twice or four times as many are taken, and
        %                 kept by solves with 'warm' that ask for the same. Default 1e-4; 0, which takes the modes as they are, where 'warm' is true, where
        %                 'error' is false and where 'refine' or 'planar' choose the modes
        %
        %   eq has the fields
        %     status ('converged' or 'unstable'), stable
        %     tip_position (3 x 1, m), tip_rotation (3 x 3)
        %     tubes (1 x m), and for these tubes pull (m), rotation (rad), tension (N), torque (N m)
        %     inputs (1 x 2m): what the columns of jacobian are, such as 'pull 2'
        %     jacobian (6 x 2m): tip twist (m, rad) by what is prescribed of each actuator
        %     response (2m x 2m): its conjugate (effort of a motion, motion of an effort) by the same
        %     compliance (6 x 6): tip twist by a wrench on the tip
        %     response_by_wrench (2m x 6)
        %     elastic_energy (J), total_bend (rad), margin (1 at rest, 0 where it snaps), iterations, residual
        %     error: what the modes leave out of the tip (m), and of any force (N) and torque (N m); NaN where it is not known. Where the tip's is
        %     above 1e-4 of the length the warning cppr:error says so
        %     length of the centreline (m), shape: see help cppr.Robot.shape
        %   A robot of parts and joints has no modes: elastic_energy, margin and residual are NaN, error is that of its integration, and of the options it
        %   takes 'stretch' and 'loop_tolerance' alone.
        %   Derivatives are NaN at a fold. Without an equilibrium the error cppr:noEquilibrium says why.
            [asked, options] = robot.read(varargin, {'warm', 'sections', 'margin', 'error'});
            options = cppr.Robot.defaults(options, struct('warm', false, 'sections', 51, 'margin', true, 'error', []));
            if isempty(options.error)
                options.error = ~options.warm;
            end
            n = robot.number;
            chosen = asked.options(:, 1);
            if options.error && ~options.warm && ~any(ismember(chosen, [n.option_refine, n.option_planar, n.option_accuracy]))
                asked.options(end + 1, :) = [n.option_accuracy, 1e-4];
            end
            robot.command(asked);
            code = robot.run(options.warm);
            eq.robot = robot.name;
            eq.status = 'converged';
            if code == n.code_unstable
                eq.status = 'unstable';
            end
            eq.stable = code ~= n.code_unstable;
            get = @(value) cppr_mex('get', robot.id, value);
            eq.tip_position = get(n.value_tip_position);
            eq.tip_rotation = reshape(get(n.value_tip_rotation), 3, 3)';
            eq.tubes = robot.actuated;
            for what = {'pull', 'rotation', 'tension', 'torque'}
                all = get(n.(['value_' what{1}]));
                eq.(what{1}) = all(robot.actuated)';
            end
            eq.inputs = robot.inputs;
            places = robot.places;
            width = 2 * robot.tubes;
            J = reshape(get(n.value_jacobian), width, 6)';
            eq.jacobian = J(:, places);
            R = reshape(get(n.value_response), width, width)';
            eq.response = R(places, places);
            eq.compliance = reshape(get(n.value_compliance), 6, 6)';
            W = reshape(get(n.value_response_by_wrench), 6, width)';
            eq.response_by_wrench = W(places, :);
            eq.elastic_energy = get(n.value_elastic_energy);
            eq.total_bend = get(n.value_total_bend);
            if options.margin
                eq.margin = get(n.value_margin);
            end
            if options.error
                eq.error = get(n.value_error);
                if eq.error(1) > 1e-4 * robot.length
                    advice = '; ''refine'' takes more modes, up to 8 times as many';
                    if robot.hasParts
                        advice = '';
                    end
                    warning('cppr:error', 'the tip is known to within %.2g mm only%s', 1e3 * eq.error(1), advice);
                end
            end
            eq.iterations = get(n.value_iterations);
            eq.residual = get(n.value_residual);
            eq.length = get(n.value_length);
            if options.sections > 0
                eq.shape = robot.shape(linspace(0, eq.length, options.sections));
            end
        end

        function [J, eq] = jacobian(robot, varargin)
        %JACOBIAN  Tip twist (m, rad) by what is prescribed of each actuator, 6 x 2m, at the equilibrium under a command.
        %
        %   [J, eq] = robot.jacobian('pull', 5e-3)    takes what solve takes; eq.inputs names the columns
            eq = robot.solve('sections', 0, 'margin', false, 'error', false, varargin{:});
            J = eq.jacobian;
        end

        function shape = shape(robot, x)
        %SHAPE  Fields along the robot at its last equilibrium, at labels x from 0 to its length (m).
        %
        %   Labels are rest abscissae of tube 1, in a robot of parts and joints lengths of the centreline, from 0 to eq.length. Such a robot has x, centre,
        %   rotation, centroid and abscissa (n x tubes, m) alone, NaN beyond the ends of a tube.
        %
        %   x (n x 1), centre (n x 3, m), rotation (3 x 3 x n), curvature of the leader (n x 3, 1/m), and for every tube, n x 3 x tubes:
        %   centroid (m), moment (torque and the two bending moments, N m), force (axial and the two shear forces, N)
            n = robot.number;
            if nargin < 2
                x = linspace(0, cppr_mex('get', robot.id, n.value_length), 101);
            end
            x = double(x(:)');
            field = @(which) cppr_mex('field', robot.id, which, x);
            shape.x = x';
            shape.centre = field(n.field_centre)';
            shape.rotation = permute(reshape(field(n.field_rotation), 3, 3, []), [2 1 3]);
            names = {'centroid'};
            if robot.hasParts
                shape.abscissa = field(n.field_abscissa)';
            else
                shape.curvature = field(n.field_curvature)';
                names = {'centroid', 'moment', 'force'};
            end
            for what = names
                shape.(what{1}) = permute(reshape(field(n.(['field_' what{1}])), 3, robot.tubes, []), [3 1 2]);
            end
        end

        function many = solveMany(robot, varargin)
        %SOLVEMANY  Many poses at once, on all cores.
        %
        %   many = robot.solveMany('pull', {2, p, 3, q}, 'tip_force', F)
        %
        %   takes the command of solve; every number may be a column of P numbers instead, tip_force and tip_moment P x 3. A single
        %   number, or 1 x 3, holds for all poses. Beside 'planar', 'refine' and so on ('accuracy', 0 unless given, looks at eight of every 20 000 poses):
        %   'jacobian'    true: jacobian (6 x 2m x P) and compliance (6 x 6 x P)
        %   'margin'      true: margin (P x 1)
        %   'start'       'rest' (default: no pose depends on another) or 'neighbour' (faster where poses next to each other are near)
        %   'threads'     default: one per core
        %
        %   many has status (P x 1: 0 stable, 1 unstable, 2 no equilibrium, then all else is NaN), stable (P x 1), tip_position (P x 3),
        %   tip_rotation (3 x 3 x P), tubes (1 x m), pull, rotation, tension, torque (P x m), elastic_energy, total_bend (P x 1).
            [asked, options] = robot.read(varargin, {'jacobian', 'margin', 'start', 'threads'});
            options = cppr.Robot.defaults(options, struct('jacobian', false, 'margin', false, 'start', 'rest', 'threads', 0));
            many = robot.run_many(asked, options);
        end

        function refine = fewestModes(robot, varargin)
        %FEWESTMODES  How many times the usual modes some poses need or bear with, as 'refine' of solve takes it: for a loop that moves between them.
        %
        %   refine = robot.fewestModes('pull', [0; 5e-3])
        %   eq = robot.solve('pull', 2e-3, 'warm', true, 'refine', refine)
        %
        %   takes the poses of solveMany and 'accuracy', the error of a tip as a part of the length, 1e-4 unless given: 0.375, 0.5, 0.75 or 1, and 2 or 4 where more are
        %   needed. Forces and derivatives become coarser with the tip. Takes some tens of milliseconds per pose.
            [asked, ~] = robot.read(varargin, {});
            n = robot.number;
            accuracy = 1e-4;
            given = asked.options(:, 1) == n.option_accuracy;
            if any(given)
                accuracy = asked.options(find(given, 1, 'last'), 2);
            end
            asked.options(given | asked.options(:, 1) == n.option_refine, :) = [];
            [columns, poses] = robot.common(asked);
            table = reshape([columns.values], poses, [])';
            refine = cppr_mex('fewest', robot.id, accuracy, [columns.number], [columns.tube], table);
        end

        function many = sweep(robot, varargin)
        %SWEEP  All combinations of the values of several inputs.
        %
        %   many = robot.sweep('pull', linspace(-5e-3, 5e-3, 41), 'rotate', linspace(0, pi, 13))
        %
        %   takes what solveMany takes; every input with more than one number is an axis of a grid (tip_force and tip_moment are not: give one
        %   for all). The result is that of solveMany, one row per point of the grid, and has
        %     axes (1 x k cell): names such as 'pull 2', the first running fastest; grid (1 x k): their sizes
        %     axis_values (1 x k cell): their numbers; reshape(many.margin, many.grid) is the margin on a grid of two or more axes
            [asked, options] = robot.read(varargin, {'jacobian', 'margin', 'start', 'threads'});
            options = cppr.Robot.defaults(options, struct('jacobian', false, 'margin', false, 'start', 'rest', 'threads', 0));
            axes = find(cellfun(@numel, {asked.inputs.values}) > 1);
            if isempty(axes)
                error('cppr:argument', 'sweep needs at least one input with more than one value');
            end
            if any([asked.inputs(axes).tube] == 0)
                error('cppr:argument', 'tip_force and tip_moment cannot be axes of a sweep: give one for all poses, or use solveMany');
            end
            values = {asked.inputs(axes).values};
            grid = cell(1, numel(axes));
            [grid{:}] = ndgrid(values{:});
            for k = 1:numel(axes)
                asked.inputs(axes(k)).values = grid{k}(:);
            end
            many = robot.run_many(asked, options);
            many.axes = arrayfun(@(own) sprintf('%s %d', own.what, own.tube), asked.inputs(axes), 'UniformOutput', false);
            many.grid = cellfun(@numel, values);
            many.axis_values = cellfun(@(own) own(:)', values, 'UniformOutput', false);
        end

        function handles = plot(robot, eq, varargin)
        %PLOT  Draws an equilibrium into the current axes, in mm: the centreline and, dashed, the centroid line of every tube.
        %
        %   robot.plot(eq)            in the plane where it lies in it, in space otherwise
        %   robot.plot(eq, 'r')       with a colour for the centreline; gives the handles of the lines
            if ~isstruct(eq) || ~isfield(eq, 'shape')
                error('cppr:argument', 'plot needs an equilibrium with its shape: leave ''sections'' as it is in solve');
            end
            colour = 'k';
            if ~isempty(varargin)
                colour = varargin{1};
            end
            centre = 1e3 * eq.shape.centre;
            centroid = 1e3 * eq.shape.centroid;
            flat = max(abs(centre(:, 3))) < 1e-6 && max(max(abs(centroid(:, 3, :)))) < 1e-6;
            lines = cat(3, centroid, centre);
            before = ishold();
            count = size(lines, 3);
            handles = zeros(1, count);
            greys = [0.25 0.5 0.7];
            for k = 1:count
                own = lines(:, :, k);
                style = {'Color', greys(min(k, 3)) * [1 1 1], 'LineStyle', '--'};
                if k == count
                    style = {'Color', colour, 'LineStyle', '-', 'LineWidth', 1.5};
                end
                if flat
                    h = plot(own(:, 1), own(:, 2), style{:});
                else
                    h = plot3(own(:, 1), own(:, 2), own(:, 3), style{:});
                end
                handles(k) = double(h);
                hold('on');
            end
            axis('equal');
            grid('on');
            xlabel('x (mm)');
            ylabel('y (mm)');
            if ~flat
                zlabel('z (mm)');
            end
            title(sprintf('%s, %s', robot.name, eq.status));
            if ~before
                hold('off');
            end
        end

        function disp(robot)
            fprintf('  Robot %s: %d tubes, %.1f mm\n', robot.name, robot.tubes, 1e3 * robot.length);
        end
    end

    methods (Static)
        function robot = fromText(text)
        %FROMTEXT  A robot from the text of a robot file.
            robot = cppr.Robot(text, 1);
        end
    end

    methods (Access = private)
        function [asked, options] = read(robot, pairs, extras)
            % Name-value pairs as inputs (what, first number, tube, values), loads, options of the solver, and those named in `extras`.
            if mod(numel(pairs), 2) ~= 0
                error('cppr:argument', 'after the robot come pairs of a name and a value, as in solve(''pull'', 5e-3)');
            end
            asked.inputs = struct('what', {}, 'number', {}, 'tube', {}, 'values', {});
            asked.loads = {};
            asked.options = zeros(0, 2);
            options = struct();
            n = robot.number;
            settings = {'planar', 'stretch', 'printed', 'relative_angle', 'refine', 'tolerance', 'accuracy', 'loop_tolerance'};
            for k = 1:2:numel(pairs)
                what = char(pairs{k});
                value = pairs{k + 1};
                switch what
                    case {'pull', 'rotate', 'tension', 'torque'}
                        if ~iscell(value)
                            if isempty(robot.actuated)
                                error('cppr:command', '%s: this robot has only its leader, nothing to actuate', what);
                            end
                            value = {robot.actuated(min(1 + robot.hasParts, numel(robot.actuated))), value};
                        end
                        if mod(numel(value), 2) ~= 0
                            error('cppr:argument', '%s takes a number, or {tube, number, tube, number, ...}', what);
                        end
                        for j = 1:2:numel(value)
                            tube = value{j};
                            if ~(isnumeric(tube) && isscalar(tube) && tube == fix(tube) && tube > 0)
                                error('cppr:argument', '%s takes a number, or {tube, number, tube, number, ...}', what);
                            end
                            asked.inputs(end + 1) = robot.input(what, n.(what), double(tube), value{j + 1});
                        end
                    case {'tip_force', 'tip_moment'}
                        if ~(isnumeric(value) && (numel(value) == 3 || size(value, 2) == 3))
                            error('cppr:argument', '%s takes three numbers, or in solveMany P x 3', what);
                        end
                        if numel(value) == 3
                            value = value(:)';
                        end
                        for axis = 1:3
                            asked.inputs(end + 1) = robot.input(what, n.(what) + axis - 1, 0, value(:, axis));
                        end
                    case 'loads'
                        if ~iscell(value)
                            value = {value};
                        end
                        asked.loads = value;
                    case settings
                        if ~(isscalar(value) && (isnumeric(value) || islogical(value)))
                            error('cppr:argument', '%s takes one number, or true or false', what);
                        end
                        asked.options(end + 1, :) = [n.(['option_' what]), double(value)];
                    case extras
                        options.(what) = value;
                    otherwise
                        known = [{'pull', 'rotate', 'tension', 'torque', 'tip_force', 'tip_moment', 'loads'}, settings, extras];
                        error('cppr:argument', 'there is no ''%s''; known are%s', what, sprintf(' %s', known{:}));
                end
            end
            % Motion and effort of one degree of freedom exclude each other.
            kinds = [asked.inputs.number];
            kinds(kinds == n.tension) = n.pull;
            kinds(kinds == n.torque) = n.rotate;
            if any(diff(sort(100 * [asked.inputs.tube] + kinds)) == 0)
                error('cppr:command', 'a degree of freedom is given twice: give either pull or tension, either rotate or torque, each once');
            end
        end

        function own = input(~, what, number, tube, values)
            if ~(isnumeric(values) && isreal(values) && isvector(values))
                error('cppr:argument', '%s takes real numbers', what);
            end
            own = struct('what', what, 'number', number, 'tube', tube, 'values', double(values(:)));
        end

        function command(robot, asked)
            % Puts a command of single numbers into the solver.
            cppr_mex('hold', robot.id);
            n = robot.number;
            fresh = [n.option_planar 0; n.option_stretch 0; n.option_printed 0; n.option_relative_angle 0; n.option_refine 1; ...
                     n.option_tolerance 1e-11; n.option_accuracy 0; n.option_loop_tolerance 1e-8];
            for option = [fresh; asked.options]'
                cppr_mex('option', robot.id, option(1), option(2));
            end
            for own = asked.inputs
                if ~isscalar(own.values)
                    error('cppr:argument', '%s takes one number here; solveMany takes many', own.what);
                end
                cppr_mex('set', robot.id, own.number, own.tube, own.values);
            end
            for own = asked.loads
                load = own{1};
                if ~(isstruct(load) && isfield(load, 'cppr_load'))
                    error('cppr:argument', 'loads takes a cell array of cppr.wrench, cppr.distributed, cppr.gravity and cppr.thread');
                end
                cppr_mex('load', robot.id, load.cppr_load, load.numbers);
            end
        end

        function code = run(robot, warm)
            [code, why, doubt] = cppr_mex('solve', robot.id, double(warm));
            if code == robot.number.code_no_equilibrium
                error('cppr:noEquilibrium', '%s', cppr.Robot.text(why));
            end
            if ~isempty(doubt)
                warning('cppr:unit', '%s', cppr.Robot.text(doubt));
            end
        end

        function [columns, poses] = common(robot, asked)
            % Puts what many poses have in common into the solver; the inputs that vary, or one that does not where none does, and how many poses there are.
            counts = cellfun(@numel, {asked.inputs.values});
            poses = max([1, counts]);
            if any(counts ~= 1 & counts ~= poses)
                error('cppr:argument', 'the inputs have %s values: give as many for each, or one', mat2str(unique(counts(counts > 1))));
            end
            varies = counts > 1;
            common = asked;
            common.inputs = asked.inputs(~varies);
            robot.command(common);
            columns = asked.inputs(varies);
            if isempty(columns)
                columns = struct('number', robot.number.tip_force, 'tube', 0, 'values', 0);
                tip = [asked.inputs.number] == columns.number;
                if any(tip)
                    columns.values = asked.inputs(tip).values;
                end
            end
        end

        function many = run_many(robot, asked, options)
            [columns, poses] = robot.common(asked);
            n = robot.number;
            switch char(options.start)
                case 'rest'
                    start = n.start_rest;
                case 'neighbour'
                    start = n.start_neighbour;
                otherwise
                    error('cppr:argument', 'start is ''rest'' or ''neighbour''');
            end
            m = robot.tubes;
            wanted = {'status', 1; 'tip_position', 3; 'tip_rotation', 9; 'pull', m; 'rotation', m; 'tension', m; 'torque', m; ...
                      'elastic_energy', 1; 'total_bend', 1};
            if options.jacobian
                wanted = [wanted; {'jacobian', 12 * m; 'compliance', 36}];
            end
            if options.margin
                wanted = [wanted; {'margin', 1}];
            end
            numbers = cellfun(@(what) n.(['value_' what]), wanted(:, 1)');
            table = [columns.values]';
            % In pieces, between which Ctrl-C is heard.
            piece = 20000;
            out = zeros(sum([wanted{:, 2}]), poses);
            for first = 1:piece:poses
                own = first:min(first + piece - 1, poses);
                out(:, own) = cppr_mex('many', robot.id, start, [columns.number], [columns.tube], table(:, own), numbers, options.threads);
            end
            last = cumsum([wanted{:, 2}]);
            many.poses = poses;
            many.tubes = robot.actuated;
            many.inputs = robot.inputs;
            for k = 1:size(wanted, 1)
                rows = out(last(k) - wanted{k, 2} + 1:last(k), :);
                what = wanted{k, 1};
                switch what
                    case {'pull', 'rotation', 'tension', 'torque'}
                        rows = rows(robot.actuated, :)';
                    case 'tip_rotation'
                        rows = permute(reshape(rows, 3, 3, poses), [2 1 3]);
                    case 'compliance'
                        rows = permute(reshape(rows, 6, 6, poses), [2 1 3]);
                    case 'jacobian'
                        rows = permute(reshape(rows, 2 * m, 6, poses), [2 1 3]);
                        rows = rows(:, robot.places, :);
                    otherwise
                        rows = rows';
                end
                many.(what) = rows;
            end
            many.stable = many.status == 0;
        end
    end

    methods (Static, Access = private)
        function bytes = utf8(text)
            bytes = unicode2native(char(text), 'UTF-8');
            bytes = bytes(:)';
        end

        function text = text(bytes)
            text = native2unicode(bytes, 'UTF-8');
        end

        function options = defaults(options, known)
            for name = fieldnames(known)'
                if ~isfield(options, name{1})
                    options.(name{1}) = known.(name{1});
                end
            end
        end
    end
end
