function load = gravity(acceleration)
%CPPR.GRAVITY  Gravity (m/s^2) in the base frame, for 'loads'; it acts on every tube that has mass.
%
%   cppr.gravity([0 0 -9.81])

if nargin ~= 1 || ~isnumeric(acceleration) || numel(acceleration) ~= 3
    error('cppr:argument', 'gravity takes three components of an acceleration');
end
load = struct('cppr_load', 3, 'numbers', double(acceleration(:)'));
end
