function load = wrench(force, varargin)
%CPPR.WRENCH  A concentrated force (N) and moment (N m), for 'loads'.
%
%   cppr.wrench([0 0.1 0])                      dead force on the tip
%   cppr.wrench([0 0.1 0], 'at', 0.015)         on the section with this label (m)
%   'moment', [x y z]    'point', [x y z] in the section's frame (m)    'frame', 'base' (default) or 'section' (turns with the robot)

own = struct('moment', [0 0 0], 'at', NaN, 'point', [0 0 0], 'frame', 'base');
for k = 1:2:numel(varargin) - 1
    name = char(varargin{k});
    if ~isfield(own, name)
        error('cppr:argument', 'a wrench has no ''%s''; it has moment, at, point and frame', name);
    end
    own.(name) = varargin{k + 1};
end
if ~any(strcmp(char(own.frame), {'base', 'section'}))
    error('cppr:argument', 'the frame of a wrench is ''base'' or ''section''');
end
frame = double(strcmp(char(own.frame), 'section'));
numbers = [three('force', force), three('moment', own.moment), frame, one('at', own.at), three('point', own.point)];
load = struct('cppr_load', 1, 'numbers', numbers);
end

function value = three(name, value)
if ~(isnumeric(value) && isreal(value) && numel(value) == 3)
    error('cppr:argument', '%s of a wrench takes three numbers', name);
end
value = double(value(:)');
end

function value = one(name, value)
if ~(isnumeric(value) && isreal(value) && isscalar(value))
    error('cppr:argument', '%s of a wrench takes one number', name);
end
value = double(value);
end
