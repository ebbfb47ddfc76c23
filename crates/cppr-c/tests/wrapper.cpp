// The C++ header against numbers of the program and against itself. The argument is the folder of the robots.
#include <cppr.hpp>

#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>

static int passed = 0;

static void expect(bool holds, const char *what) {
    if (!holds) {
        throw std::runtime_error(what);
    }
    ++passed;
}

template <typename Call> static void refuses(Call call, int code, const char *part) {
    try {
        call();
    } catch (const cppr::Error &error) {
        expect(error.code() == code, error.what());
        expect(std::string(error.what()).find(part) != std::string::npos, error.what());
        return;
    }
    throw std::runtime_error(std::string("not refused: ") + part);
}

static void test(const std::string &robots) {
    const cppr::Robot robot = cppr::Robot::from_file(robots + "/childs3.toml");
    expect(robot.name() == "Childs3" && robot.tubes() == 3 && robot.length() == 0.03, "the robot");
    expect(!robot.is_actuated(1) && robot.is_actuated(3) && !robot.is_actuated(4) && !robot.is_planar(), "its tubes");
    expect(robot.sudden_changes().empty() && robot.with_modes().name() == "Childs3", "a robot with modes has them already");
    cppr::Solver solver(robot);
    solver.pull(2, 1e-3);
    solver.pull(3, -0.5e-3);
    solver.rotate(2, 0.5235987755982988);
    solver.tip_force({0.0, 0.0, -0.1});
    expect(solver.solve() == cppr::Status::stable, "stable");
    const cppr::Vector tip = solver.tip_position();
    // cppr solve robots/childs3.toml --pull 2=1mm --pull 3=-0.5mm --rotate 2=30deg --tip-force 0,0,-0.1N --json -
    expect(std::abs(tip[0] - 0.025214277012) < 1e-10 && std::abs(tip[1] + 0.003405373597) < 1e-10 &&
               std::abs(tip[2] - 0.012881528391) < 1e-10,
           "tip position");
    expect(std::abs(solver.tension(2) - 13.922371778) < 1e-7 && std::abs(solver.torque(3) + 0.005096658389) < 1e-9, "efforts");
    expect(std::isnan(solver.motion(1)) && std::abs(solver.motion(3) + 0.5e-3) < 1e-15, "motions");
    expect(std::abs(solver.number(CPPR_VALUE_MARGIN) - 0.7336014589) < 1e-7, "margin");
    expect(solver.explain() == "converged, stable" && solver.doubt().empty(), "sentences");

    // The Jacobian and the compliance against differences; a copy stands where its original does.
    const cppr::Matrix jacobian = solver.jacobian(), compliance = solver.compliance();
    cppr::Solver copy = solver;
    expect(copy.track() == cppr::Status::stable && copy.number(CPPR_VALUE_ITERATIONS) <= 1.0, "a copy starts where its original stands");
    const auto differs = [&](cppr_input input, std::uint32_t tube, double at, double step, const cppr::Matrix &matrix, std::size_t column,
                             double tolerance) {
        cppr::Vector sides[2];
        for (int side = 0; side < 2; ++side) {
            copy.set(input, tube, at + (side == 0 ? step : -step));
            expect(copy.track() == cppr::Status::stable, "stable beside");
            sides[side] = copy.tip_position();
        }
        copy.set(input, tube, at);
        for (std::size_t row = 0; row < 3; ++row) {
            expect(std::abs((sides[0][row] - sides[1][row]) / (2.0 * step) - matrix(row, column)) < tolerance, "a derivative");
        }
    };
    differs(CPPR_INPUT_PULL, 3, -0.5e-3, 1e-6, jacobian, cppr::translation(3), 1e-4);
    differs(CPPR_INPUT_ROTATE, 2, 0.5235987755982988, 1e-5, jacobian, cppr::turn(2), 1e-7);
    differs(CPPR_INPUT_TIP_FORCE_Y, 0, 0.0, 1e-4, compliance, 1, 1e-6);
    expect(std::isnan(jacobian(0, cppr::translation(1))), "the leader has no column");

    const std::vector<cppr::Vector> line = solver.centreline({0.0, 0.03});
    expect(line[0][0] == 0.0 && std::abs(line[1][2] - tip[2]) < 1e-12, "centreline");

    cppr::Matrix poses(40, 2);
    for (std::size_t pose = 0; pose < 40; ++pose) {
        poses.data()[2 * pose] = 0.1 * static_cast<double>(pose);
        poses.data()[2 * pose + 1] = -1e-5 * static_cast<double>(pose);
    }
    poses.data()[2 * 5] = -500.0;
    const cppr::Matrix many =
        solver.solve_many({{CPPR_INPUT_TENSION, 2}, {CPPR_INPUT_PULL, 3}}, poses, {CPPR_VALUE_STATUS, CPPR_VALUE_TIP_POSITION});
    expect(many.rows() == 40 && many.columns() == 4, "size of many");
    expect(many(5, 0) == CPPR_CODE_NO_EQUILIBRIUM && std::isnan(many(5, 1)), "a pose that is none");
    solver.pull_with(2, poses(39, 0));
    solver.pull(3, poses(39, 1));
    expect(solver.solve() == cppr::Status::stable && std::abs(solver.tip_position()[1] - many(39, 2)) < 1e-9, "the last of many");

    // One solver per thread, one robot for all.
    double tips[4] = {};
    std::vector<std::thread> threads;
    for (int own = 0; own < 4; ++own) {
        threads.emplace_back([&robot, &tips, own] {
            cppr::Solver mine(robot);
            mine.pull(2, 1e-3);
            tips[own] = mine.solve() == cppr::Status::stable ? mine.tip_position()[1] : 0.0;
        });
    }
    for (std::thread &thread : threads) {
        thread.join();
    }
    expect(tips[0] != 0.0 && tips[0] == tips[1] && tips[1] == tips[2] && tips[2] == tips[3], "the same in all threads");

    solver.pull_with(2, -500.0);
    expect(solver.track() == cppr::Status::none, "no equilibrium");
    expect(solver.explain().find("not converged") != std::string::npos, "why not");
    refuses([&] { (void)solver.tip_position(); }, CPPR_CODE_NO_VALUE, "found no equilibrium");
    solver.pull(2, std::numeric_limits<double>::quiet_NaN());
    refuses([&] { (void)solver.solve(); }, CPPR_CODE_BAD_COMMAND, "not finite");
    refuses([&] { solver.pull(1, 0.0); }, CPPR_CODE_BAD_COMMAND, "tube 1 is the leader");
    refuses([&] { solver.option(CPPR_OPTION_REFINE, 0.0); }, CPPR_CODE_BAD_ARGUMENT, "cannot be 0");
    refuses([&] { (void)cppr::Robot::from_file("none"); }, CPPR_CODE_BAD_ROBOT, "cannot be read");
    refuses([&] { (void)cppr::Robot::from_text("name = 3"); }, CPPR_CODE_BAD_ROBOT, "line 1");
    refuses([&] { (void)solver.solve_many({{CPPR_INPUT_PULL, 2}}, poses, {CPPR_VALUE_STATUS}); }, CPPR_CODE_BAD_ARGUMENT, "one column");
    solver.hold();
    expect(solver.solve() == cppr::Status::stable && std::abs(solver.tip_position()[0] - 0.03) < 1e-12, "held, it is straight");
}

/// A robot of parts and joints, opened and asked as any other.
static void test_parts(const std::string &robots) {
    const cppr::Robot robot = cppr::Robot::from_file(robots + "/bundles/two_sections.toml");
    expect(robot.has_parts() && robot.tubes() == 4 && robot.is_actuated(1) && robot.is_actuated(4) && !robot.is_actuated(5), "its tubes");
    cppr::Solver solver(robot);
    solver.pull(2, 3e-3);
    solver.rotate(4, 0.3);
    solver.tip_force({0.0, 0.0, 0.02});
    expect(solver.solve() == cppr::Status::stable && solver.explain() == "converged, stable", "stable");
    const cppr::Vector tip = solver.tip_position();
    const cppr::Matrix jacobian = solver.jacobian(), compliance = solver.compliance();
    expect(std::abs(solver.motion(2) - 3e-3) < 1e-15 && solver.motion(1) == 0.0 && solver.tension(2) > 0.0, "motors");
    const double length = solver.number(CPPR_VALUE_LENGTH);
    const std::vector<cppr::Vector> line = solver.centreline({0.0, length});
    // Along the robot it is integrated in shorter steps.
    expect(line[0][0] == 0.0 && std::abs(line[1][1] - tip[1]) < 1e-9, "centreline");
    cppr::Solver copy = solver;
    const auto differs = [&](cppr_input input, std::uint32_t tube, double at, double step, const cppr::Matrix &matrix, std::size_t column,
                             double tolerance) {
        cppr::Vector sides[2];
        for (int side = 0; side < 2; ++side) {
            copy.set(input, tube, at + (side == 0 ? step : -step));
            expect(copy.track() == cppr::Status::stable, "stable beside");
            sides[side] = copy.tip_position();
        }
        copy.set(input, tube, at);
        double size = 0.0;
        for (std::size_t row = 0; row < 3; ++row) {
            expect(std::abs((sides[0][row] - sides[1][row]) / (2.0 * step) - matrix(row, column)) < tolerance, "a derivative");
            size = std::fmax(size, std::abs(matrix(row, column)));
        }
        expect(size > 100.0 * tolerance, "a derivative that is not nothing");
    };
    differs(CPPR_INPUT_PULL, 2, 3e-3, 1e-5, jacobian, cppr::translation(2), 1e-3);
    differs(CPPR_INPUT_ROTATE, 1, 0.0, 1e-4, jacobian, cppr::turn(1), 1e-6);
    differs(CPPR_INPUT_TIP_FORCE_Z, 0, 0.02, 1e-3, compliance, 2, 1e-5);

    cppr::Matrix poses(20, 1);
    for (std::size_t pose = 0; pose < 20; ++pose) {
        poses.data()[pose] = 1.5e-4 * static_cast<double>(pose + 1);
    }
    const auto many = [&](cppr_start start, std::size_t threads) {
        return solver.solve_many({{CPPR_INPUT_PULL, 2}}, poses, {CPPR_VALUE_STATUS, CPPR_VALUE_TIP_POSITION}, start, threads);
    };
    const cppr::Matrix cold = many(CPPR_START_REST, 1), warm = many(CPPR_START_NEIGHBOUR, 2), alone = many(CPPR_START_NEIGHBOUR, 1);
    expect(cold(19, 0) == 0.0 && std::abs(cold(19, 2) - tip[1]) < 1e-8 && std::abs(warm(19, 2) - tip[1]) < 1e-8, "the last of many");
    bool same = true;
    for (std::size_t cell = 0; cell < warm.size(); ++cell) {
        same = same && warm.data()[cell] == alone.data()[cell];
    }
    expect(same, "the numbers do not depend on the threads");

    refuses([&] { (void)solver.number(CPPR_VALUE_MARGIN); }, CPPR_CODE_NO_VALUE, "parts and joints do not have it");
    refuses([&] { (void)robot.with_modes(); }, CPPR_CODE_BAD_ROBOT, "has no modes");
    refuses([&] { solver.option(CPPR_OPTION_REFINE, 2.0); }, CPPR_CODE_BAD_ARGUMENT, "only the stretch");
    solver.pull(2, 5.0);
    refuses([&] { (void)solver.solve(); }, CPPR_CODE_BAD_COMMAND, "behind the plate");
    solver.hold();
    solver.rotate(2, 90.0);
    expect(solver.doubt().find("Check number and unit") != std::string::npos, "degrees");
}

int main(int argc, char **argv) {
    if (argc != 2) {
        return 2;
    }
    try {
        test(argv[1]);
        test_parts(argv[1]);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "wrapper: %s\n", error.what());
        return 1;
    }
    std::printf("%d passed, 0 failed\n", passed);
    return 0;
}
