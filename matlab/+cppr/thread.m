function load = thread(tension, pulley, varargin)
%CPPR.THREAD  A thread under a tension (N) from the tip over a pulley at [x y z] (m) in the base frame, for 'loads'.
%
%   cppr.thread(0.05, [0.03 -0.02 0])
%   'radius', r of the pulley (m; default 0, an eyelet)    'side', 'left' (default) or 'right': where it runs onto the pulley, seen from
%   the tip along the thread with +Z up    'point', [x y z]: where it is tied, in the tip section's frame (m)

own = struct('radius', 0, 'side', 'left', 'point', [0 0 0]);
for k = 1:2:numel(varargin) - 1
    name = char(varargin{k});
    if ~isfield(own, name)
        error('cppr:argument', 'a thread has no ''%s''; it has radius, side and point', name);
    end
    own.(name) = varargin{k + 1};
end
if ~any(strcmp(char(own.side), {'left', 'right'}))
    error('cppr:argument', 'the side of a thread is ''left'' or ''right''');
end
if numel(pulley) ~= 3 || numel(own.point) ~= 3 || ~isscalar(tension) || ~isscalar(own.radius)
    error('cppr:argument', 'a thread takes its tension, three coordinates of the pulley, and a radius and a point of three coordinates');
end
left = double(strcmp(char(own.side), 'left'));
load = struct('cppr_load', 4, 'numbers', double([tension, pulley(:)', own.radius, left, own.point(:)']));
end
