function residuals = calibration_residuals(data, keys, parameters)
%CALIBRATION_RESIDUALS  Computed minus measured tips over their deviations, robots with other numbers in their files; see calibrate.

residuals = [];
for own = data
    text = own.text;
    for p = 1:numel(keys)
        text = regexprep(text, [keys{p} ' = [0-9.]+'], sprintf('%s = %.12g', keys{p}, parameters(p)));
    end
    many = cppr.Robot.fromText(text).solveMany('pull', own.pull, 'tip_force', own.force);
    if ~all(many.stable)
        error('calibrate: the robot has no stable equilibrium where it was measured');
    end
    gap = bsxfun(@rdivide, many.tip_position - own.tip, own.sigma);
    residuals = [residuals; gap(:)];
end
end
