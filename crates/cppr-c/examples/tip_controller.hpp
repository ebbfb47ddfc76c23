// The core of a ROS 2 node, without ROS: a controller that moves the tip of a push-pull robot to a wanted position. A node owns one, feeds it
// measured joints and wanted tips, and publishes what it gives. What to paste around it is in the book, "C and C++".
#ifndef TIP_CONTROLLER_HPP
#define TIP_CONTROLLER_HPP

#include <cppr.hpp>

#include <cmath>
#include <string>
#include <vector>

/// Resolved rates with damped least squares on all translations (and rotations, where wanted) of the actuated tubes.
class TipController {
public:
    struct Settings {
        double gain = 5.0;        ///< Part of the error that is closed per second (1/s).
        double damping = 1e-3;    ///< Against singular poses: length per motor step that counts as nothing (m per m, m per rad).
        double most_pull = 5e-3;  ///< Translations stay within ± this (m).
    };

    /// Where the robot stands after an update.
    struct State {
        cppr::Vector tip;             ///< Centre of the tip section in the base frame (m).
        std::array<double, 9> rotation; ///< Its rotation, row by row.
        std::vector<double> tension;  ///< Force on every joint (N).
    };

    TipController(const std::string &robot_file, Settings settings)
        : settings_(settings), solver_(cppr::Robot::from_file(robot_file)) {
        const std::size_t tubes = solver_.robot().tubes();
        for (std::uint32_t tube = 1; tube <= tubes; ++tube) {
            if (solver_.robot().is_actuated(tube)) {
                tubes_.push_back(tube);
                names_.push_back("tube" + std::to_string(tube) + "_translation");
            }
        }
        joints_.assign(tubes_.size(), 0.0);
        state_.tension.assign(tubes_.size(), 0.0);
        solve();
    }

    /// Names of the joints, as sensor_msgs/JointState has them, in the order of `joints`.
    const std::vector<std::string> &names() const { return names_; }
    /// Commanded translations (m), pull positive.
    const std::vector<double> &joints() const { return joints_; }
    const State &state() const { return state_; }

    /// One cycle of `dt` seconds towards a wanted tip (m); false, and joints as they were, where the model has no stable equilibrium there.
    /// Allocates nothing.
    bool update(const cppr::Vector &wanted, double dt) {
        const cppr::Matrix &j = solver_.jacobian();
        // (J Jᵀ + λ²) y = e, step = Jᵀ y, with the three rows of the tip's translation.
        double a[3][4] = {};
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::uint32_t tube : tubes_) {
                    a[r][c] += j(r, cppr::translation(tube)) * j(c, cppr::translation(tube));
                }
            }
            a[r][r] += settings_.damping * settings_.damping;
            a[r][3] = settings_.gain * dt * (wanted[r] - state_.tip[r]);
        }
        eliminate(a);
        for (std::size_t i = 0; i < tubes_.size(); ++i) {
            double step = 0.0;
            for (std::size_t r = 0; r < 3; ++r) {
                step += j(r, cppr::translation(tubes_[i])) * a[r][3];
            }
            const double next = std::fmin(std::fmax(joints_[i] + step, -settings_.most_pull), settings_.most_pull);
            solver_.pull(tubes_[i], next);
        }
        if (!solve()) {
            for (std::size_t i = 0; i < tubes_.size(); ++i) {
                solver_.pull(tubes_[i], joints_[i]);
            }
            solve();
            return false;
        }
        return true;
    }

private:
    bool solve() {
        if (solver_.track() != cppr::Status::stable) {
            return false;
        }
        state_.tip = solver_.tip_position();
        state_.rotation = solver_.tip_rotation();
        for (std::size_t i = 0; i < tubes_.size(); ++i) {
            joints_[i] = solver_.motion(tubes_[i]);
            state_.tension[i] = solver_.tension(tubes_[i]);
        }
        return true;
    }

    /// Gauss's elimination of a positive definite system of three; the solution is left in the last column.
    static void eliminate(double (&a)[3][4]) {
        for (int p = 0; p < 3; ++p) {
            for (int r = 0; r < 3; ++r) {
                const double factor = r == p ? 0.0 : a[r][p] / a[p][p];
                for (int c = p; c < 4; ++c) {
                    a[r][c] -= factor * a[p][c];
                }
            }
        }
        for (int p = 0; p < 3; ++p) {
            a[p][3] /= a[p][p];
        }
    }

    Settings settings_;
    cppr::Solver solver_;
    std::vector<std::uint32_t> tubes_;
    std::vector<std::string> names_;
    std::vector<double> joints_;
    State state_{};
};

#endif
