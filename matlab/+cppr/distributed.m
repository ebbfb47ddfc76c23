function load = distributed(force, from, to)
%CPPR.DISTRIBUTED  A dead force per length (N/m) in the base frame between two labels (m), for 'loads'.
%
%   cppr.distributed([0 0 -1], 0, 0.02)

if nargin ~= 3 || ~isnumeric(force) || numel(force) ~= 3 || ~isscalar(from) || ~isscalar(to)
    error('cppr:argument', 'a distributed load takes three components of a force per length and two labels');
end
load = struct('cppr_load', 2, 'numbers', [double(force(:)'), double(from), double(to)]);
end
