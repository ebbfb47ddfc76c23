// A control loop at 1 kHz: the tip of a three-tube robot follows a circle. Every cycle tracks the equilibrium, takes the Jacobian and moves
// the motors; measured are how late the cycles begin (jitter) and how long they take.
//
//     loop_1khz robots/childs3.toml [seconds]
//
// As root, or with the right to real-time priority, it runs under SCHED_FIFO with its memory locked; otherwise it says so.
#include <cppr.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <sched.h>
#include <sys/mman.h>

namespace {

constexpr long period = 1'000'000; // ns
constexpr double radius = 5e-3;    // m

double micros(const timespec &from, const timespec &to) {
    return 1e6 * static_cast<double>(to.tv_sec - from.tv_sec) + 1e-3 * static_cast<double>(to.tv_nsec - from.tv_nsec);
}

void print(const char *what, std::vector<double> &times) {
    std::sort(times.begin(), times.end());
    const auto at = [&](double part) { return times[static_cast<std::size_t>(part * static_cast<double>(times.size() - 1))]; };
    std::printf("%-12s median %7.1f   99 %% %7.1f   99.9 %% %7.1f   most %7.1f us\n", what, at(0.5), at(0.99), at(0.999), at(1.0));
}

/// Follows the circle for a time; gives the largest distance of the tip from where it was to be (m).
double follow(cppr::Solver &solver, std::size_t cycles, std::vector<double> &late, std::vector<double> &busy) {
    constexpr double dt = 1e-9 * period, pi = 3.14159265358979, rate = 2.0 * pi / 2.0; // a turn in 2 s
    double motors[2] = {0.0, 0.0}, worst = 0.0;
    timespec due{};
    clock_gettime(CLOCK_MONOTONIC, &due);
    for (std::size_t cycle = 0; cycle < cycles; ++cycle) {
        due.tv_nsec += period;
        if (due.tv_nsec >= 1'000'000'000) {
            due.tv_nsec -= 1'000'000'000;
            ++due.tv_sec;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
        timespec begin{}, end{};
        clock_gettime(CLOCK_MONOTONIC, &begin);

        const double phase = rate * dt * static_cast<double>(cycle);
        // Out to the circle in the first tenth of a second.
        const double r = radius * std::min(1.0, static_cast<double>(cycle) / 100.0);
        const double wanted[2] = {r * std::cos(phase), r * std::sin(phase)};
        solver.pull(2, motors[0]);
        solver.pull(3, motors[1]);
        if (solver.track() != cppr::Status::stable) {
            throw cppr::Error(CPPR_CODE_NO_VALUE, solver.explain());
        }
        const cppr::Vector tip = solver.tip_position();
        const cppr::Matrix &jacobian = solver.jacobian();
        // Tip y and z by the two translations; Newton's step towards the wanted tip.
        const double a = jacobian(1, cppr::translation(2)), b = jacobian(1, cppr::translation(3));
        const double c = jacobian(2, cppr::translation(2)), d = jacobian(2, cppr::translation(3));
        const double y = wanted[0] - tip[1], z = wanted[1] - tip[2], determinant = a * d - b * c;
        motors[0] += (d * y - b * z) / determinant;
        motors[1] += (a * z - c * y) / determinant;

        clock_gettime(CLOCK_MONOTONIC, &end);
        late[cycle] = micros(due, begin);
        busy[cycle] = micros(begin, end);
        if (cycle > 100) {
            worst = std::max(worst, std::hypot(y, z));
        }
    }
    return worst;
}

} // namespace

int main(int argc, char **argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: loop_1khz robots/childs3.toml [seconds]\n");
        return 2;
    }
    const double seconds = argc > 2 ? std::atof(argv[2]) : 10.0;
    const auto cycles = static_cast<std::size_t>(std::max(0.2, seconds) * 1e9 / period);
    try {
        const cppr::Robot robot = cppr::Robot::from_file(argv[1]);
        cppr::Solver solver(robot);
        std::vector<double> late(cycles), busy(cycles);
        // The first turns allocate: before the loop, not in it.
        for (int warm = 0; warm < 3; ++warm) {
            solver.pull(2, 1e-5 * warm);
            solver.pull(3, 0.0);
            (void)solver.track();
            (void)solver.jacobian();
        }
        sched_param priority{};
        priority.sched_priority = 80;
        const bool real_time = mlockall(MCL_CURRENT | MCL_FUTURE) == 0 && sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
        std::printf("%s: %zu cycles of 1 ms, %s\n", robot.name().c_str(), cycles,
                    real_time ? "SCHED_FIFO, memory locked" : "ordinary priority (no right to SCHED_FIFO)");
        const double worst = follow(solver, cycles, late, busy);
        const auto missed = std::count_if(busy.begin(), busy.end(), [](double time) { return time > 1e-3 * period; });
        print("begun late", late);
        print("computing", busy);
        std::printf("cycles longer than 1 ms: %ld; tip at most %.3f mm from where it was to be\n", static_cast<long>(missed), 1e3 * worst);
        return worst < 0.1e-3 ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "loop_1khz: %s\n", error.what());
        return 1;
    }
}
