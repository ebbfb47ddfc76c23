/* A robot from its file, pulled, read and followed; what is wrong is said. Give it the path of robots/r3.toml. */
#include <cppr.h>
#include <stdio.h>

static int complain(const char *what) {
    fprintf(stderr, "%s: %s\n", what, cppr_error_text());
    return 1;
}

int main(int argc, char **argv) {
    cppr_robot *robot;
    cppr_solver *solver;
    double tip[3], tension[2], jacobian[6 * 4];
    int code;
    if (argc != 2 || cppr_abi() != CPPR_ABI) {
        fprintf(stderr, "usage: first robots/r3.toml\n");
        return 2;
    }
    robot = cppr_robot_from_file(argv[1]);
    if (!robot) {
        return complain("robot");
    }
    printf("%s: %d tubes, %.0f mm\n", cppr_robot_name(robot), (int)cppr_robot_tubes(robot), 1e3 * cppr_robot_length(robot));
    solver = cppr_solver_new(robot);
    cppr_solver_set(solver, CPPR_INPUT_PULL, 2, 5e-3);
    code = cppr_solver_solve(solver);
    if (code < 0) {
        return complain("solve");
    }
    printf("%s\n", cppr_solver_explain(solver));
    if (code != CPPR_CODE_NO_EQUILIBRIUM) {
        if (cppr_solver_get(solver, CPPR_VALUE_TIP_POSITION, tip, 3) < 0 ||
            cppr_solver_get(solver, CPPR_VALUE_TENSION, tension, 2) < 0 ||
            cppr_solver_get(solver, CPPR_VALUE_JACOBIAN, jacobian, 24) < 0) {
            return complain("values");
        }
        printf("tip at %.3f %.3f %.3f mm, pulled with %.4f N\n", 1e3 * tip[0], 1e3 * tip[1], 1e3 * tip[2], tension[1]);
        printf("the tip moves across by %.3f mm per mm of pull\n", jacobian[1 * 4 + 2]);
    }
    cppr_solver_free(solver);
    cppr_robot_free(robot);
    return 0;
}
