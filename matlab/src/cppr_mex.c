/*
 * What cppr.Robot calls: the C interface as one MEX function, for MATLAB and Octave.
 *
 *   numbers                = cppr_mex('numbers')                       struct of all enumerators
 *   id                     = cppr_mex('open', text, from_file)         a robot and its solver
 *   id                     = cppr_mex('with_modes', id)                the same with modes, where sudden changes made it one of parts
 *                            cppr_mex('close', id)
 *   info                   = cppr_mex('info', id)
 *                            cppr_mex('option', id, option, value)
 *                            cppr_mex('hold', id)
 *                            cppr_mex('set', id, input, tube, value)
 *                            cppr_mex('load', id, kind, numbers)       kind 1 wrench, 2 distributed, 3 gravity, 4 thread
 *   [code, why, doubt]     = cppr_mex('solve', id, warm)
 *   values                 = cppr_mex('get', id, value)                one column; NaN where there is none
 *   values                 = cppr_mex('field', id, field, labels)      one column per label
 *   values                 = cppr_mex('many', id, start, inputs, tubes, table, wanted, threads)
 *                                                                      table and values have one column per pose
 *   refine                 = cppr_mex('fewest', id, accuracy, inputs, tubes, table)
 *
 * Texts go both ways as UTF-8 in uint8, since the two programs keep characters differently. What the library refuses becomes an error
 * cppr:argument, cppr:robot, cppr:command or cppr:internal. Robots are named by numbers, looked up here, so that a wrong one is no crash.
 */
#include "cppr.h"
#include "mex.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST 4096

static struct {
    cppr_robot *robot;
    cppr_solver *solver;
} kept[MOST];

static void give_back(int place) {
    cppr_solver_free(kept[place].solver);
    cppr_robot_free(kept[place].robot);
    kept[place].solver = NULL;
    kept[place].robot = NULL;
}

static void give_all_back(void) {
    int place;
    for (place = 0; place < MOST; ++place) {
        give_back(place);
    }
}

/* Errors leave through here: mexErrMsgIdAndTxt does not return. */
static void require(int holds, const char *text) {
    if (!holds) {
        mexErrMsgIdAndTxt("cppr:argument", "%s", text);
    }
}

static int checked(int code) {
    if (code < 0 && code != CPPR_CODE_NO_VALUE) {
        const char *name = code == CPPR_CODE_BAD_COMMAND ? "cppr:command"
                           : code == CPPR_CODE_BAD_ROBOT ? "cppr:robot"
                           : code == CPPR_CODE_INTERNAL  ? "cppr:internal"
                                                         : "cppr:argument";
        mexErrMsgIdAndTxt(name, "%s", cppr_error_text());
    }
    return code;
}

static double number(int count, const mxArray **in, int place) {
    require(place < count && mxIsDouble(in[place]) && !mxIsComplex(in[place]) && mxGetNumberOfElements(in[place]) == 1,
            "cppr_mex: a real number is wanted");
    return mxGetScalar(in[place]);
}

static uint32_t whole(int count, const mxArray **in, int place) {
    double value = number(count, in, place);
    require(value >= 0.0 && value <= 4294967295.0 && floor(value) == value, "cppr_mex: a whole number is wanted");
    return (uint32_t)value;
}

static const double *numbers(int count, const mxArray **in, int place, size_t *size) {
    require(place < count && mxIsDouble(in[place]) && !mxIsComplex(in[place]) && !mxIsSparse(in[place]),
            "cppr_mex: an array of real numbers is wanted");
    *size = mxGetNumberOfElements(in[place]);
    return mxGetPr(in[place]);
}

/* Whole numbers of an array, in memory that MEX frees. */
static uint32_t *wholes(int count, const mxArray **in, int place, size_t *size) {
    const double *from = numbers(count, in, place, size);
    uint32_t *to = mxMalloc((*size + 1) * sizeof *to);
    size_t i;
    for (i = 0; i < *size; ++i) {
        require(from[i] >= 0.0 && from[i] <= 4294967295.0 && floor(from[i]) == from[i], "cppr_mex: whole numbers are wanted");
        to[i] = (uint32_t)from[i];
    }
    return to;
}

static mxArray *utf8(const char *text) {
    size_t size = text ? strlen(text) : 0;
    mxArray *out = mxCreateNumericMatrix(1, (mwSize)size, mxUINT8_CLASS, mxREAL);
    if (size > 0) {
        memcpy(mxGetData(out), text, size);
    }
    return out;
}

static void name_number(mxArray *all, const char *name, double value) {
    mxAddField(all, name);
    mxSetField(all, 0, name, mxCreateDoubleScalar(value));
}

static mxArray *all_numbers(void) {
    static const struct {
        const char *name;
        int value;
    } list[] = {
        {"pull", CPPR_INPUT_PULL},
        {"rotate", CPPR_INPUT_ROTATE},
        {"tension", CPPR_INPUT_TENSION},
        {"torque", CPPR_INPUT_TORQUE},
        {"tip_force", CPPR_INPUT_TIP_FORCE_X},
        {"tip_moment", CPPR_INPUT_TIP_MOMENT_X},
        {"value_status", CPPR_VALUE_STATUS},
        {"value_fraction", CPPR_VALUE_FRACTION},
        {"value_iterations", CPPR_VALUE_ITERATIONS},
        {"value_residual", CPPR_VALUE_RESIDUAL},
        {"value_elastic_energy", CPPR_VALUE_ELASTIC_ENERGY},
        {"value_total_bend", CPPR_VALUE_TOTAL_BEND},
        {"value_margin", CPPR_VALUE_MARGIN},
        {"value_tip_position", CPPR_VALUE_TIP_POSITION},
        {"value_tip_rotation", CPPR_VALUE_TIP_ROTATION},
        {"value_pull", CPPR_VALUE_PULL},
        {"value_rotation", CPPR_VALUE_ROTATION},
        {"value_tension", CPPR_VALUE_TENSION},
        {"value_torque", CPPR_VALUE_TORQUE},
        {"value_jacobian", CPPR_VALUE_JACOBIAN},
        {"value_response", CPPR_VALUE_RESPONSE},
        {"value_compliance", CPPR_VALUE_COMPLIANCE},
        {"value_response_by_wrench", CPPR_VALUE_RESPONSE_BY_WRENCH},
        {"value_error", CPPR_VALUE_ERROR},
        {"value_length", CPPR_VALUE_LENGTH},
        {"field_centre", CPPR_FIELD_CENTRE},
        {"field_rotation", CPPR_FIELD_ROTATION},
        {"field_curvature", CPPR_FIELD_CURVATURE},
        {"field_abscissa", CPPR_FIELD_ABSCISSA},
        {"field_centroid", CPPR_FIELD_CENTROID},
        {"field_moment", CPPR_FIELD_MOMENT},
        {"field_force", CPPR_FIELD_FORCE},
        {"option_planar", CPPR_OPTION_PLANAR},
        {"option_stretch", CPPR_OPTION_STRETCH},
        {"option_refine", CPPR_OPTION_REFINE},
        {"option_tolerance", CPPR_OPTION_TOLERANCE},
        {"option_printed", CPPR_OPTION_PRINTED},
        {"option_relative_angle", CPPR_OPTION_RELATIVE_ANGLE},
        {"option_accuracy", CPPR_OPTION_ACCURACY},
        {"option_loop_tolerance", CPPR_OPTION_LOOP_TOLERANCE},
        {"code_unstable", CPPR_CODE_UNSTABLE},
        {"code_no_equilibrium", CPPR_CODE_NO_EQUILIBRIUM},
        {"start_rest", CPPR_START_REST},
        {"start_neighbour", CPPR_START_NEIGHBOUR},
        {"frame_base", CPPR_FRAME_BASE},
        {"frame_section", CPPR_FRAME_SECTION},
    };
    mxArray *all = mxCreateStructMatrix(1, 1, 0, NULL);
    size_t i;
    for (i = 0; i < sizeof list / sizeof list[0]; ++i) {
        name_number(all, list[i].name, list[i].value);
    }
    return all;
}

/* Keeps a robot with a solver of its own; null says why there is none. */
static mxArray *keep(cppr_robot *robot) {
    int place = 0;
    if (!robot) {
        checked(CPPR_CODE_BAD_ROBOT);
    }
    while (place < MOST && kept[place].robot) {
        ++place;
    }
    if (place == MOST) {
        cppr_robot_free(robot);
        require(0, "too many robots are open: clear some");
    }
    kept[place].robot = robot;
    kept[place].solver = cppr_solver_new(robot);
    return mxCreateDoubleScalar(place + 1);
}

static mxArray *open_robot(int count, const mxArray **in) {
    cppr_robot *robot;
    size_t size;
    char *text;
    require(count > 2 && mxIsUint8(in[1]), "cppr_mex: a text in UTF-8 is wanted");
    size = mxGetNumberOfElements(in[1]);
    text = mxMalloc(size + 1);
    memcpy(text, mxGetData(in[1]), size);
    text[size] = '\0';
    require(strlen(text) == size, "the text contains a zero");
    robot = number(count, in, 2) != 0.0 ? cppr_robot_from_file(text) : cppr_robot_from_text(text);
    mxFree(text);
    return keep(robot);
}

static int place_of(int count, const mxArray **in) {
    uint32_t id = whole(count, in, 1);
    require(id >= 1 && id <= MOST && kept[id - 1].solver, "this robot has been closed: open it again");
    return (int)id - 1;
}

static mxArray *info(const cppr_robot *robot) {
    size_t tubes = cppr_robot_tubes(robot), tube;
    mxArray *all = mxCreateStructMatrix(1, 1, 0, NULL);
    mxArray *actuated = mxCreateDoubleMatrix(1, (mwSize)tubes, mxREAL);
    for (tube = 1; tube <= tubes; ++tube) {
        mxGetPr(actuated)[tube - 1] = cppr_robot_is_actuated(robot, (uint32_t)tube);
    }
    mxAddField(all, "name");
    mxSetField(all, 0, "name", utf8(cppr_robot_name(robot)));
    mxAddField(all, "sudden");
    mxSetField(all, 0, "sudden", utf8(cppr_robot_sudden_changes(robot)));
    name_number(all, "length", cppr_robot_length(robot));
    name_number(all, "planar", cppr_robot_is_planar(robot));
    name_number(all, "parts", cppr_robot_has_parts(robot));
    mxAddField(all, "actuated");
    mxSetField(all, 0, "actuated", actuated);
    return all;
}

static void add_load(cppr_solver *solver, int count, const mxArray **in) {
    size_t size;
    uint32_t kind = whole(count, in, 2);
    const double *n = numbers(count, in, 3, &size);
    static const size_t sizes[] = {0, 11, 5, 3, 9};
    require(kind >= 1 && kind <= 4 && size == sizes[kind], "cppr_mex: a load has another number of numbers");
    switch (kind) {
    case 1: /* force, moment, frame, label (NaN: tip), point */
        checked(cppr_solver_add_wrench(solver, n, n + 3, (uint32_t)n[6], isnan(n[7]) ? NULL : n + 7, n + 8));
        break;
    case 2: /* force per length, from, to */
        checked(cppr_solver_add_distributed(solver, n, n[3], n[4]));
        break;
    case 3: /* acceleration */
        checked(cppr_solver_add_gravity(solver, n));
        break;
    default: /* tension, pulley, radius, left, point */
        checked(cppr_solver_add_thread(solver, n[0], n + 1, n[4], n[5] != 0.0, n + 6));
    }
}

static mxArray *solve_many(const cppr_solver *solver, int count, const mxArray **in) {
    uint32_t start = whole(count, in, 2), threads;
    size_t columns, tube_count, cells, wanted_count, width = 0, poses, i;
    uint32_t *inputs = wholes(count, in, 3, &columns), *tubes = wholes(count, in, 4, &tube_count), *wanted;
    const double *table = numbers(count, in, 5, &cells);
    mxArray *out;
    require(columns > 0 && columns == tube_count && mxGetM(in[5]) == columns, "cppr_mex: inputs, tubes and table do not fit");
    poses = cells / columns;
    wanted = wholes(count, in, 6, &wanted_count);
    threads = whole(count, in, 7);
    for (i = 0; i < wanted_count; ++i) {
        width += cppr_solver_size(solver, wanted[i]);
    }
    out = mxCreateDoubleMatrix((mwSize)width, (mwSize)poses, mxREAL);
    if (poses > 0) {
        checked(cppr_solve_many(solver, start, poses, columns, inputs, tubes, table, wanted_count, wanted, mxGetPr(out), width * poses,
                                threads));
    }
    mxFree(inputs);
    mxFree(tubes);
    mxFree(wanted);
    return out;
}

static mxArray *fewest_modes(cppr_solver *solver, int count, const mxArray **in) {
    double accuracy = number(count, in, 2), refine = NAN;
    size_t columns, tube_count, cells;
    uint32_t *inputs = wholes(count, in, 3, &columns), *tubes = wholes(count, in, 4, &tube_count);
    const double *table = numbers(count, in, 5, &cells);
    require(columns > 0 && columns == tube_count && mxGetM(in[5]) == columns, "cppr_mex: inputs, tubes and table do not fit");
    if (checked(cppr_solver_fewest_modes(solver, accuracy, cells / columns, columns, inputs, tubes, table, &refine)) == CPPR_CODE_NO_EQUILIBRIUM) {
        mexErrMsgIdAndTxt("cppr:noEquilibrium", "%s", cppr_error_text());
    }
    mxFree(inputs);
    mxFree(tubes);
    return mxCreateDoubleScalar(refine);
}

void mexFunction(int count_out, mxArray **out, int count, const mxArray **in) {
    char task[16];
    cppr_solver *solver;
    int place;
    require(count > 0 && mxIsChar(in[0]) && mxGetString(in[0], task, sizeof task) == 0, "cppr_mex: a task is wanted");
    require(cppr_abi() == CPPR_ABI, "cppr_mex was built with another version of the library: build it again");
    mexAtExit(give_all_back);
    if (strcmp(task, "numbers") == 0) {
        out[0] = all_numbers();
        return;
    }
    if (strcmp(task, "open") == 0) {
        out[0] = open_robot(count, in);
        return;
    }
    place = place_of(count, in);
    solver = kept[place].solver;
    if (strcmp(task, "close") == 0) {
        give_back(place);
    } else if (strcmp(task, "info") == 0) {
        out[0] = info(kept[place].robot);
    } else if (strcmp(task, "with_modes") == 0) {
        out[0] = keep(cppr_robot_with_modes(kept[place].robot));
    } else if (strcmp(task, "option") == 0) {
        checked(cppr_solver_set_option(solver, whole(count, in, 2), number(count, in, 3)));
    } else if (strcmp(task, "hold") == 0) {
        checked(cppr_solver_hold(solver));
    } else if (strcmp(task, "set") == 0) {
        checked(cppr_solver_set(solver, whole(count, in, 2), whole(count, in, 3), number(count, in, 4)));
    } else if (strcmp(task, "load") == 0) {
        add_load(solver, count, in);
    } else if (strcmp(task, "solve") == 0) {
        int code = checked(number(count, in, 2) != 0.0 ? cppr_solver_track(solver) : cppr_solver_solve(solver));
        out[0] = mxCreateDoubleScalar(code);
        if (count_out > 1) {
            out[1] = utf8(code == CPPR_CODE_OK ? "" : cppr_solver_explain(solver));
        }
        if (count_out > 2) {
            out[2] = utf8(cppr_solver_doubt(solver));
        }
    } else if (strcmp(task, "get") == 0) {
        uint32_t value = whole(count, in, 2);
        size_t size = cppr_solver_size(solver, value);
        out[0] = mxCreateDoubleMatrix((mwSize)size, 1, mxREAL);
        checked(cppr_solver_get(solver, value, mxGetPr(out[0]), size));
    } else if (strcmp(task, "field") == 0) {
        uint32_t field = whole(count, in, 2);
        size_t labels, size = cppr_solver_field_size(solver, field);
        const double *at = numbers(count, in, 3, &labels);
        out[0] = mxCreateDoubleMatrix((mwSize)size, (mwSize)labels, mxREAL);
        checked(cppr_solver_get_field(solver, field, at, labels, mxGetPr(out[0]), size * labels));
    } else if (strcmp(task, "many") == 0) {
        out[0] = solve_many(solver, count, in);
    } else if (strcmp(task, "fewest") == 0) {
        out[0] = fewest_modes(solver, count, in);
    } else {
        require(0, "cppr_mex: there is no such task");
    }
}
