%% Calibrate R1 and R2 from measured tips
% One centroid offset factor and one Young's modulus for both prototypes, by Gauss and Newton's method on the robot files. Run it from the
% folder matlab, after build_cppr. The program cppr does more: outliers, a refusal of what the data cannot see (`cppr calibrate`).

file = fopen(fullfile('..', 'examples', 'calibration', 'measured.csv'));
columns = textscan(file, '%s %f %f %f %f %f %f', 'Delimiter', ',', 'HeaderLines', 1);
fclose(file);
names = {'R1', 'R2'};
data = struct('text', {}, 'pull', {}, 'force', {}, 'tip', {}, 'sigma', {});
for r = 1:2
    own = strcmp(columns{1}, names{r});
    data(r).text = fileread(fullfile('..', 'robots', [lower(names{r}) '.toml']));
    data(r).pull = 1e-3 * columns{2}(own);
    data(r).force = [zeros(sum(own), 1), columns{3}(own), zeros(sum(own), 1)];
    data(r).tip = 1e-3 * [columns{4}(own), columns{5}(own), columns{6}(own)];
    data(r).sigma = 1e-3 * columns{7}(own);
end

%% The fit
% A parameter is a number in the text of the robot file. Derivatives are central differences.
keys = {'centroid_offset_factor', 'youngs_modulus_GPa'};
designed = [1.27; 5.39];
parameters = designed;
step = 1e-4 * parameters;
for iteration = 1:20
    J = zeros(numel(calibration_residuals(data, keys, parameters)), 2);
    for p = 1:2
        there = parameters;
        back = parameters;
        there(p) = there(p) + step(p);
        back(p) = back(p) - step(p);
        J(:, p) = (calibration_residuals(data, keys, there) - calibration_residuals(data, keys, back)) / (2 * step(p));
    end
    move = -J \ calibration_residuals(data, keys, parameters);
    parameters = parameters + move;
    if all(abs(move) < 1e-7 * parameters)
        break
    end
end
residuals = calibration_residuals(data, keys, parameters);
scale = sqrt(sum(residuals .^ 2) / (numel(residuals) - 2));
deviation = scale * sqrt(diag(inv(J' * J)));
for p = 1:2
    fprintf('%-24s %.4f, standard deviation %.4f\n', keys{p}, parameters(p), deviation(p));
end

%% Before and after
figure();
states = {designed, 'kx', 'as designed'; parameters, 'ko', 'calibrated'};
for r = 1:2
    subplot(1, 2, r);
    hold('on');
    for state = states'
        gap = reshape(calibration_residuals(data(r), keys, state{1}), [], 3);
        distance = 1e3 * sqrt(sum(bsxfun(@times, gap, data(r).sigma) .^ 2, 2));
        fprintf('%s %s: rms distance %.3f mm\n', names{r}, state{3}, sqrt(mean(distance .^ 2)));
        plot(1e3 * data(r).pull, distance, state{2}, 'DisplayName', state{3});
    end
    hold('off');
    title(names{r});
    xlabel('pull (mm)');
    ylabel('distance to the measured tip (mm)');
    ylim([0 6]);
    legend('show', 'Location', 'northoutside');
end
print('-dpng', 'calibrate.png');
