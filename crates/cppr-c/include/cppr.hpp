// C++17 on top of cppr.h, header-only. SI units, frames and numbers of tubes as there.
//
// What fails throws cppr::Error. That a robot has no equilibrium is no failure but a Status to look at. After its constructor a Solver
// allocates nothing in set, track, tip_position, tip_rotation, motion, rotation, tension, torque, jacobian and compliance, unless its robot is of parts
// and joints.
//
// Threads: share a Robot freely; one thread at a time may use a Solver. Copy a Solver for another thread.
#ifndef CPPR_HPP
#define CPPR_HPP

#include "cppr.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace cppr {

using Vector = std::array<double, 3>;

/// A call that failed: a cppr_code and a sentence.
class Error : public std::runtime_error {
public:
    Error(int code, const std::string &text) : std::runtime_error(text), code_(code) {}

    /// CPPR_CODE_BAD_COMMAND and so on.
    int code() const noexcept { return code_; }

private:
    int code_;
};

/// How a solve ended.
enum class Status { stable = CPPR_CODE_OK, unstable = CPPR_CODE_UNSTABLE, none = CPPR_CODE_NO_EQUILIBRIUM };

/// Rows and columns of numbers, row by row.
class Matrix {
public:
    Matrix(std::size_t rows, std::size_t columns) : columns_(columns), cells_(rows * columns) {}

    double operator()(std::size_t row, std::size_t column) const { return cells_.at(row * columns_ + column); }
    std::size_t rows() const noexcept { return columns_ == 0 ? 0 : cells_.size() / columns_; }
    std::size_t columns() const noexcept { return columns_; }
    const double *data() const noexcept { return cells_.data(); }
    double *data() noexcept { return cells_.data(); }
    std::size_t size() const noexcept { return cells_.size(); }

private:
    std::size_t columns_;
    std::vector<double> cells_;
};

/// Column of the Jacobian (row and column of the response) for the translation of a tube.
constexpr std::size_t translation(std::uint32_t tube) { return 2 * (std::size_t{tube} - 1); }
/// The same for its rotation.
constexpr std::size_t turn(std::uint32_t tube) { return translation(tube) + 1; }

/// Throws where a call failed.
inline int check(int code) {
    if (code < 0) {
        throw Error(code, cppr_error_text());
    }
    return code;
}

/// A checked robot. Copies share it.
class Robot {
public:
    static Robot from_file(const std::string &path) { return Robot(cppr_robot_from_file(path.c_str())); }
    static Robot from_text(const std::string &toml) { return Robot(cppr_robot_from_text(toml.c_str())); }

    std::string name() const { return cppr_robot_name(get()); }
    /// Rest length, of parts and joints that of the longest tube (m).
    double length() const { return cppr_robot_length(get()); }
    /// Tubes are numbered from 1 to this.
    std::size_t tubes() const { return cppr_robot_tubes(get()); }
    bool is_actuated(std::uint32_t tube) const { return cppr_robot_is_actuated(get(), tube); }
    bool is_planar() const { return cppr_robot_is_planar(get()); }
    /// Is it of parts and joints? Then tube 1 has an actuator too, and margin, energy and options of the modes are not there.
    bool has_parts() const { return cppr_robot_has_parts(get()); }
    /// Where sudden changes are for which tubes of one length became one of parts and joints; empty for other robots.
    std::string sudden_changes() const {
        const char *places = cppr_robot_sudden_changes(get());
        return places ? places : "";
    }
    /// The same with modes, which do not follow sudden changes.
    Robot with_modes() const { return Robot(cppr_robot_with_modes(get())); }
    const cppr_robot *get() const noexcept { return own_.get(); }

private:
    explicit Robot(cppr_robot *own) : own_(own, cppr_robot_free) {
        if (!own) {
            throw Error(CPPR_CODE_BAD_ROBOT, cppr_error_text());
        }
        if (cppr_abi() != CPPR_ABI) {
            throw Error(CPPR_CODE_BAD_ARGUMENT, "the library cppr that was loaded is not of the version of this program's header");
        }
    }

    std::shared_ptr<cppr_robot> own_;
};

/// A command, buffers and the last equilibrium of a robot.
class Solver {
public:
    explicit Solver(const Robot &robot)
        : robot_(robot), own_(cppr_solver_new(robot.get())), line_(robot.tubes()), jacobian_(6, 2 * robot.tubes()),
          compliance_(6, 6) {
        require();
    }

    Solver(const Solver &other)
        : robot_(other.robot_), own_(cppr_solver_clone(other.get())), line_(other.line_), jacobian_(other.jacobian_),
          compliance_(other.compliance_) {
        require();
    }

    Solver(Solver &&) noexcept = default;
    Solver &operator=(Solver &&) noexcept = default;
    Solver &operator=(const Solver &other) { return *this = Solver(other); }

    const Robot &robot() const noexcept { return robot_; }
    cppr_solver *get() const noexcept { return own_.get(); }

    /// Prescribes an input; tube 0 for inputs on the tip.
    void set(cppr_input input, std::uint32_t tube, double value) { check(cppr_solver_set(get(), input, tube, value)); }
    /// Translation of a tube (m), pull positive.
    void pull(std::uint32_t tube, double value) { set(CPPR_INPUT_PULL, tube, value); }
    /// Rotation of a tube (rad).
    void rotate(std::uint32_t tube, double value) { set(CPPR_INPUT_ROTATE, tube, value); }
    /// Force that pulls a tube (N).
    void pull_with(std::uint32_t tube, double value) { set(CPPR_INPUT_TENSION, tube, value); }
    /// Torque that turns a tube (N m).
    void turn_with(std::uint32_t tube, double value) { set(CPPR_INPUT_TORQUE, tube, value); }
    /// Dead force on the tip in the base frame (N).
    void tip_force(const Vector &value) { three(CPPR_INPUT_TIP_FORCE_X, value); }
    /// Dead moment on the tip in the base frame (N m).
    void tip_moment(const Vector &value) { three(CPPR_INPUT_TIP_MOMENT_X, value); }
    void option(cppr_option option, double value) { check(cppr_solver_set_option(get(), option, value)); }
    /// Holds all actuators and takes all loads away.
    void hold() { check(cppr_solver_hold(get())); }
    void unload() { check(cppr_solver_unload(get())); }
    // Other loads: cppr_solver_add_wrench(solver.get(), ...) and so on.

    /// From rest.
    [[nodiscard]] Status solve() { return static_cast<Status>(check(cppr_solver_solve(get()))); }
    /// From the last equilibrium found: for control loops.
    [[nodiscard]] Status track() { return static_cast<Status>(check(cppr_solver_track(get()))); }
    /// How the last solve ended.
    std::string explain() const { return cppr_solver_explain(get()); }
    /// What of the command looks like a mistaken unit; empty where nothing does.
    std::string doubt() const {
        const char *text = cppr_solver_doubt(get());
        return text ? text : "";
    }

    /// Writes a value of the last solve into an array of exactly its size.
    void read(cppr_value value, double *out, std::size_t count) { check(cppr_solver_get(get(), value, out, count)); }
    double number(cppr_value value) {
        double out = 0.0;
        read(value, &out, 1);
        return out;
    }
    /// Centre of the tip section (m).
    Vector tip_position() {
        Vector out{};
        read(CPPR_VALUE_TIP_POSITION, out.data(), out.size());
        return out;
    }
    /// Rotation of the tip section, row by row.
    std::array<double, 9> tip_rotation() {
        std::array<double, 9> out{};
        read(CPPR_VALUE_TIP_ROTATION, out.data(), out.size());
        return out;
    }
    /// Translation of a tube (m), pull positive; NaN without actuator, as the next three.
    double motion(std::uint32_t tube) { return of_tube(CPPR_VALUE_PULL, tube); }
    /// Rotation of a tube (rad).
    double rotation(std::uint32_t tube) { return of_tube(CPPR_VALUE_ROTATION, tube); }
    /// Force on a tube (N).
    double tension(std::uint32_t tube) { return of_tube(CPPR_VALUE_TENSION, tube); }
    /// Torque on a tube (N m).
    double torque(std::uint32_t tube) { return of_tube(CPPR_VALUE_TORQUE, tube); }
    /// Twist of the tip (m, rad) by what is prescribed; columns by translation() and turn(). Valid until the next call of it.
    const Matrix &jacobian() {
        read(CPPR_VALUE_JACOBIAN, jacobian_.data(), jacobian_.size());
        return jacobian_;
    }
    /// Twist of the tip by a dead wrench on it. Valid until the next call of it.
    const Matrix &compliance() {
        read(CPPR_VALUE_COMPLIANCE, compliance_.data(), compliance_.size());
        return compliance_;
    }
    /// Centreline at labels from 0 to number(CPPR_VALUE_LENGTH) (m).
    std::vector<Vector> centreline(const std::vector<double> &labels) {
        std::vector<Vector> out(labels.size());
        double *first = out.empty() ? nullptr : out.front().data();
        check(cppr_solver_get_field(get(), CPPR_FIELD_CENTRE, labels.data(), labels.size(), first, 3 * out.size()));
        return out;
    }

    /// Solves poses that differ in `inputs` (input, tube), one row of `values` each, and gives one row of the wanted values each; NaN where a pose
    /// has no equilibrium.
    Matrix solve_many(const std::vector<std::pair<cppr_input, std::uint32_t>> &inputs, const Matrix &values,
                      const std::vector<cppr_value> &wanted, cppr_start start = CPPR_START_REST, std::size_t threads = 0) const {
        if (values.columns() != inputs.size()) {
            throw Error(CPPR_CODE_BAD_ARGUMENT, "solve_many takes one column of values for each input");
        }
        std::vector<std::uint32_t> kinds, tubes, numbers;
        for (const auto &input : inputs) {
            kinds.push_back(input.first);
            tubes.push_back(input.second);
        }
        std::size_t width = 0;
        for (cppr_value value : wanted) {
            numbers.push_back(value);
            width += cppr_solver_size(get(), value);
        }
        Matrix out(values.rows(), width);
        check(cppr_solve_many(get(), start, values.rows(), inputs.size(), kinds.data(), tubes.data(), values.data(), wanted.size(),
                              numbers.data(), out.data(), out.size(), threads));
        return out;
    }

private:
    struct Free {
        void operator()(cppr_solver *own) const noexcept { cppr_solver_free(own); }
    };

    void require() const {
        if (!own_) {
            throw Error(CPPR_CODE_BAD_ARGUMENT, cppr_error_text());
        }
    }

    void three(cppr_input first, const Vector &value) {
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            check(cppr_solver_set(get(), first + axis, 0, value[axis]));
        }
    }

    double of_tube(cppr_value value, std::uint32_t tube) {
        read(value, line_.data(), line_.size());
        return line_.at(std::size_t{tube} - 1);
    }

    Robot robot_;
    std::unique_ptr<cppr_solver, Free> own_;
    std::vector<double> line_;
    Matrix jacobian_, compliance_;
};

} // namespace cppr

#endif
