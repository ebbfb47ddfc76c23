/*
 * The C interface of cppr: statics of concentric push-pull robots. SI units throughout: m, rad, N, N m, Pa. The base frame has
 * its origin at the centre of the baseplate, X along the robot at rest.
 *
 * Made from the sources by cbindgen; the test `header` of the crate cppr-c makes it anew
 * where CPPR_WRITE_HEADER is set: CPPR_WRITE_HEADER=1 cargo test -p cppr-c --test header.
 *
 * Threads: a robot may be used by any number of threads at the same time. A solver may be used by one thread at a time, not always the same
 * one; a second thread meanwhile gets CPPR_CODE_BUSY. Error texts belong to the thread. Freeing is up to the caller: nobody may be using
 * what is freed.
 *
 * Versions: CPPR_ABI changes only where a compiled program would no longer work. Functions and enumerators are added without a change; an older
 * library answers an enumerator that it does not know with CPPR_CODE_BAD_ARGUMENT.
 */

#ifndef CPPR_H
#define CPPR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Version of the binary interface. It changes only where a compiled program would no longer work; functions and enumerators are
// added without a change.
#define CPPR_ABI 1

// How a call ended. Negative: it failed, and cppr_error_text() says why.
enum cppr_code
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done; of a solve: a stable equilibrium.
  CPPR_CODE_OK = 0,
  // A solve found an equilibrium that the robot leaves at the slightest disturbance. It can be read like a stable one.
  CPPR_CODE_UNSTABLE = 1,
  // A solve found no equilibrium: cppr_solver_explain() says why. The next warm start goes from the last one found.
  CPPR_CODE_NO_EQUILIBRIUM = 2,
  // A null pointer, a wrong size, an unknown number, no UTF-8.
  CPPR_CODE_BAD_ARGUMENT = -1,
  // The robot file cannot be read or describes no robot.
  CPPR_CODE_BAD_ROBOT = -2,
  // The command cannot be asked of this robot. Nothing was solved.
  CPPR_CODE_BAD_COMMAND = -3,
  // What is to be read does not exist: no equilibrium was found, or it has no derivative (at a fold).
  CPPR_CODE_NO_VALUE = -4,
  // Another thread is using this solver.
  CPPR_CODE_BUSY = -5,
  // A fault of the library; the solver is as new. Please report it.
  CPPR_CODE_INTERNAL = -6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_code cppr_code;
#else
typedef int32_t cppr_code;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What can be prescribed by one number. Pull is positive, push negative; rotations are right-handed about +X, the
// insertion axis. An actuator takes either motion or effort in each of its two degrees of freedom: the one given last counts.
enum cppr_input
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Translation of a tube (m).
  CPPR_INPUT_PULL = 1,
  // Rotation of a tube (rad).
  CPPR_INPUT_ROTATE = 2,
  // Force that pulls a tube (N).
  CPPR_INPUT_TENSION = 3,
  // Torque that turns a tube (N m).
  CPPR_INPUT_TORQUE = 4,
  // Dead force on the centre of the tip section along X of the base frame (N); tube 0.
  CPPR_INPUT_TIP_FORCE_X = 5,
  // The same along Y.
  CPPR_INPUT_TIP_FORCE_Y = 6,
  // The same along Z.
  CPPR_INPUT_TIP_FORCE_Z = 7,
  // Dead moment on the tip about X of the base frame (N m); tube 0.
  CPPR_INPUT_TIP_MOMENT_X = 8,
  // The same about Y.
  CPPR_INPUT_TIP_MOMENT_Y = 9,
  // The same about Z.
  CPPR_INPUT_TIP_MOMENT_Z = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_input cppr_input;
#else
typedef uint32_t cppr_input;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What can be read of an equilibrium. n is the number of tubes; tube k stands at place k − 1 of n, its translation at
// place 2 (k − 1) and its rotation at 2 (k − 1) + 1 of 2 n. Places of a tube without actuator are NaN. Matrices go row by row.
// Twists are the translation of the tip section's centre (m) and its rotation (rad), wrenches a force (N) and the moment about that
// centre (N m).
//
// A robot of parts and joints has no evaluations, load steps, residual, elastic energy and margin: CPPR_CODE_NO_VALUE.
enum cppr_value
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // 0 stable, 1 unstable, 2 no equilibrium: as cppr_code; 1 number.
  CPPR_VALUE_STATUS = 1,
  // Greatest fraction of the command at which an equilibrium was found; 1 number.
  CPPR_VALUE_FRACTION = 2,
  // Newton steps; 1 number.
  CPPR_VALUE_ITERATIONS = 3,
  // Residual evaluations; 1 number.
  CPPR_VALUE_EVALUATIONS = 4,
  // Load steps after the first attempt failed; 1 number.
  CPPR_VALUE_LOAD_STEPS = 5,
  // Largest scaled residual; 1 number.
  CPPR_VALUE_RESIDUAL = 6,
  // Elastic energy of all tubes (J); 1 number.
  CPPR_VALUE_ELASTIC_ENERGY = 7,
  // Angle by which the centreline turns in all (rad); 1 number.
  CPPR_VALUE_TOTAL_BEND = 8,
  // Margin to instability: 1 at rest, 0 where the robot snaps; 1 number. Allocates.
  CPPR_VALUE_MARGIN = 9,
  // Centre of the tip section in the base frame (m); 3.
  CPPR_VALUE_TIP_POSITION = 10,
  // Rotation of the tip section in the base frame, columns tangent, centroid's direction, normal; 3 × 3.
  CPPR_VALUE_TIP_ROTATION = 11,
  // Translation of every tube (m), pull positive; n.
  CPPR_VALUE_PULL = 12,
  // Rotation of every tube (rad); n.
  CPPR_VALUE_ROTATION = 13,
  // Force on every tube (N), pull positive; n.
  CPPR_VALUE_TENSION = 14,
  // Torque on every tube (N m); n.
  CPPR_VALUE_TORQUE = 15,
  // Twist of the tip in the base frame by what is prescribed of every tube; 6 × 2 n.
  CPPR_VALUE_JACOBIAN = 16,
  // The same in the frame of the tip section; 6 × 2 n.
  CPPR_VALUE_JACOBIAN_BODY = 17,
  // The conjugate of what is prescribed (effort where that is motion, motion where it is effort) by what is prescribed; 2 n × 2 n.
  CPPR_VALUE_RESPONSE = 18,
  // Twist of the tip by a dead wrench on it, both in the base frame; 6 × 6.
  CPPR_VALUE_COMPLIANCE = 19,
  // The conjugate of what is prescribed by a dead wrench on the tip; 2 n × 6.
  CPPR_VALUE_RESPONSE_BY_WRENCH = 20,
  // What the modes leave out, against the same robot integrated without them: error of the tip (m), greatest error of a force (N) and of a torque
  // (N m) of the actuators; 3. Not there in the printed formulation and for relative rotations. Allocates, and takes milliseconds. Of a robot of
  // parts and joints, which has no modes: how far tip and forces move when every step of the integration is halved; NaN for the torque.
  CPPR_VALUE_ERROR = 21,
  // Greatest label at which fields can be read (m): the rest length, or for a robot of parts and joints the length of its centreline; 1 number.
  CPPR_VALUE_LENGTH = 22,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_value cppr_value;
#else
typedef uint32_t cppr_value;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What can be read along the robot. n is the number of tubes, the outermost (tube 1, the leader) first.
//
// A robot of parts and joints has centre, rotation (of the outermost tube that is there), abscissa and centroid, NaN for a tube that has not begun or has
// ended. They are interpolated between sections a thousandth of the length apart.
enum cppr_field
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Centre of the section in the base frame (m); 3 numbers per section.
  CPPR_FIELD_CENTRE = 1,
  // Rotation of the leader's section in the base frame, row by row; 3 × 3.
  CPPR_FIELD_ROTATION = 2,
  // Curvature of the leader in its section's frame (1/m); 3.
  CPPR_FIELD_CURVATURE = 3,
  // Rest abscissa of the section of each tube that lies here (m); n.
  CPPR_FIELD_ABSCISSA = 4,
  // Centroid of each tube in the base frame (m); n × 3.
  CPPR_FIELD_CENTROID = 5,
  // Torque about the centre and bending moments about the section's second and third axis of each tube (N m); n × 3.
  CPPR_FIELD_MOMENT = 6,
  // Axial force, tension positive, and shear forces along the section's second and third axis of each tube (N); n × 3.
  CPPR_FIELD_FORCE = 7,
  // Elastic energy of all tubes per length (J/m); 1.
  CPPR_FIELD_ENERGY_DENSITY = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_field cppr_field;
#else
typedef uint32_t cppr_field;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How to solve. The numbers of a flag are 0 and 1. A robot of parts and joints has CPPR_OPTION_STRETCH and CPPR_OPTION_LOOP_TOLERANCE alone, and takes the defaults of the
// others, and any accuracy: nothing there has modes.
enum cppr_option
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Flag: nothing leaves the X-Y plane; faster. Default 0.
  CPPR_OPTION_PLANAR = 1,
  // Flag: the tubes stretch. Default 0.
  CPPR_OPTION_STRETCH = 2,
  // Modes and nodes multiplied: a whole number from 1 to 8, or 0.375, 0.5 or 0.75 for loops that need no more, see cppr_solver_fewest_modes(). Default 1.
  CPPR_OPTION_REFINE = 3,
  // Largest scaled residual at convergence, above 0 and at most 1e-6. Default 1e-11.
  CPPR_OPTION_TOLERANCE = 4,
  // Newton steps of one attempt, 1 to 100000. Default 40.
  CPPR_OPTION_ITERATIONS = 5,
  // Smallest fraction of the command that load stepping adds, from 1e-12 to 1. Default 1/256.
  CPPR_OPTION_SMALLEST_STEP = 6,
  // Flag: the formulation printed in the paper, for comparison only; it allocates. Default 0.
  CPPR_OPTION_PRINTED = 7,
  // Flag: rotations are relative angles of the tubes at the plate, as in the paper, not those of the motors. Default 0.
  CPPR_OPTION_RELATIVE_ANGLE = 8,
  // Error of the tip that is accepted, as a part of the length, from 0 to 1. Where the modes exceed it, cppr_solver_solve() takes twice or four times as many,
  // which takes up to some tens of milliseconds, and cppr_solver_track() goes on with as many; cppr_solve_many() looks at eight poses and takes as many for all. What
  // is left says CPPR_VALUE_ERROR. Default 0: the modes stay as they are.
  CPPR_OPTION_ACCURACY = 9,
  // Error that cppr_solver_track() allows in one step of the integration along a robot of parts and joints, in units of its length, above 0 and at most 1e-4: 1e-6 takes up to half the
  // time of the default, 1e-8, and leaves the tip within 1e-5 of the length.
  CPPR_OPTION_LOOP_TOLERANCE = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_option cppr_option;
#else
typedef uint32_t cppr_option;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// In which frame the components of a load stay constant.
enum cppr_frame
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The baseplate's: a dead load.
  CPPR_FRAME_BASE = 0,
  // The loaded section's: it turns with the robot.
  CPPR_FRAME_SECTION = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_frame cppr_frame;
#else
typedef uint32_t cppr_frame;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where a pose of many starts.
enum cppr_start
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // At rest: no pose depends on another.
  CPPR_START_REST = 0,
  // At the pose before it, where that is less than 0.35 rad of bending or turning away and the tip does not jump, else at rest: several times as fast. A
  // robot of parts and joints begins at any pose before it that is stable, so that these should be near.
  CPPR_START_NEIGHBOUR = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum cppr_start cppr_start;
#else
typedef uint32_t cppr_start;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A checked robot. Immutable: any number of threads may use it at the same time.
typedef struct cppr_robot cppr_robot;

// A command, buffers and the last equilibrium of one robot. One thread at a time may use it, not always the same; a second one meanwhile
// gets CPPR_CODE_BUSY. Take one solver per thread.
typedef struct cppr_solver cppr_solver;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Why the last call of this thread that failed did so: one or more sentences, UTF-8. Empty before the first. Valid until the next
// failure or explanation in this thread.
const char *cppr_error_text(void);

// CPPR_ABI of the library that is loaded: compare it with CPPR_ABI of the header.
uint32_t cppr_abi(void);

// Version of the library, such as "0.1.0".
const char *cppr_version(void);

// Reads a robot file of either kind: tubes of one length joined at the tip, or parts and joints. Null where it cannot be read or describes no
// robot; cppr_error_text() then lists every problem with its line. Free it with cppr_robot_free().
//
// Tubes of one length with sudden changes along them, which modes do not follow, become a robot of parts and joints, which is integrated:
// cppr_robot_sudden_changes() tells, and cppr_robot_with_modes() gives the other one.
cppr_robot *cppr_robot_from_file(const char *path);

// The same from the text of a robot file.
cppr_robot *cppr_robot_from_text(const char *text);

// Where tubes of one length have sudden changes for which they became a robot of parts and joints, in words such as "notch depth of tube 1 at 30 mm",
// valid as long as the robot; null for any other robot and for a null pointer.
const char *cppr_robot_sudden_changes(const cppr_robot *robot);

// The robot of the same file with modes, which do not follow its sudden changes: faster, less exact, with all options. A robot that has modes already is given once
// more. Null where the file says parts or joints itself. Free it with cppr_robot_free().
cppr_robot *cppr_robot_with_modes(const cppr_robot *robot);

// Frees a robot; nothing for a null pointer. Its solvers stay valid.
void cppr_robot_free(cppr_robot *robot);

// Name of the robot, valid as long as the robot; null for a null pointer.
const char *cppr_robot_name(const cppr_robot *robot);

// Rest length, of parts and joints that of the longest tube (m); NaN for a null pointer.
double cppr_robot_length(const cppr_robot *robot);

// Number of tubes, which are numbered from 1 as in the robot file; 0 for a null pointer.
size_t cppr_robot_tubes(const cppr_robot *robot);

// Is it of parts and joints, by its file or for sudden changes? Then every tube has an actuator, tube 1 too, and what depends on modes is not there:
// see cppr_value, cppr_field and cppr_option. False for a null pointer.
bool cppr_robot_has_parts(const cppr_robot *robot);

// Has a tube an actuator? Without one it is clamped in the baseplate. False for a null pointer and for a tube that does not exist.
bool cppr_robot_is_actuated(const cppr_robot *robot,
                            uint32_t tube);

// Do all centroid lines at rest lie in the X-Y plane? False for a null pointer.
bool cppr_robot_is_planar(const cppr_robot *robot);

// A solver of a robot: all actuators held, no load, at rest. Null for a null pointer. It keeps what it needs of the robot, which may be
// freed first. Free it with cppr_solver_free().
cppr_solver *cppr_solver_new(const cppr_robot *robot);

// Another solver with the same command, options and equilibrium, and buffers of its own: for another thread, or to come back to this
// equilibrium. Null where it fails.
cppr_solver *cppr_solver_clone(const cppr_solver *solver);

// Frees a solver; nothing for a null pointer.
void cppr_solver_free(cppr_solver *solver);

// Sets an option (cppr_option). The next warm start may take longer.
int32_t cppr_solver_set_option(cppr_solver *solver, uint32_t option, double value);

// Prescribes an input (cppr_input): of a tube, numbered from 1 as in the robot file, or 0 for an input on the tip. What is not prescribed
// is held, and not loaded. The number itself is checked by the solve.
int32_t cppr_solver_set(cppr_solver *solver,
                        uint32_t input,
                        uint32_t tube,
                        double value);

// Holds all actuators where they are at rest and takes all loads away. Options and the last equilibrium stay.
int32_t cppr_solver_hold(cppr_solver *solver);

// Takes all loads away, those on the tip too.
int32_t cppr_solver_unload(cppr_solver *solver);

// Adds a concentrated force (N) and moment (N m; null: none), both of three components in a frame (cppr_frame).
// `at` is the label of the loaded section, the rest abscissa of the leader, which is tube 1 (m), or null for the tip; `point` the point of action in the
// section's frame (m), or null for its centre. The number itself is checked by the solve, as with every load.
int32_t cppr_solver_add_wrench(cppr_solver *solver,
                               const double *force,
                               const double *moment,
                               uint32_t frame,
                               const double *at,
                               const double *point);

// Adds a dead force per length (N/m, three components in the base frame) between two labels (m).
int32_t cppr_solver_add_distributed(cppr_solver *solver,
                                    const double *force,
                                    double from,
                                    double to);

// Adds gravity (m/s², three components in the base frame), which acts on every tube that has mass.
int32_t cppr_solver_add_gravity(cppr_solver *solver, const double *acceleration);

// Adds a thread under a tension (N) from the tip over a pulley, whose axle is parallel to Z, with its centre at three coordinates in the base
// frame and a radius (m; 0 is an eyelet). It runs onto the pulley on its left, seen from the tip along the thread with +Z
// up, or on its right. `point` is where it is tied in the tip section's frame (m), or null for its centre.
int32_t cppr_solver_add_thread(cppr_solver *solver,
                               double tension,
                               const double *pulley,
                               double radius,
                               bool left,
                               const double *point);

// Solves for the equilibrium under the command, from rest. Gives CPPR_CODE_OK, CPPR_CODE_UNSTABLE, CPPR_CODE_NO_EQUILIBRIUM or what
// went wrong. Of several stable equilibria it finds one; which one does not depend on earlier solves.
int32_t cppr_solver_solve(cppr_solver *solver);

// The same from the last equilibrium that this solver found (at first, rest): a warm start, for control loops. It stays on the branch of that
// equilibrium where that goes on. Allocates nothing from the second call on, as long as the kinds of inputs and loads, the options and which
// tubes are pushed in stay; with a robot of parts and joints everything allocates.
int32_t cppr_solver_track(cppr_solver *solver);

// How many numbers a value (cppr_value) has; 0 where it is unknown or `solver` null.
size_t cppr_solver_size(const cppr_solver *solver, uint32_t value);

// How many numbers a field (cppr_field) has per section; 0 where it is unknown or `solver` null.
size_t cppr_solver_field_size(const cppr_solver *solver, uint32_t field);

// Writes a value (cppr_value) of the last solve into `out`, which has room for `count` numbers: exactly as many as
// cppr_solver_size() says. CPPR_CODE_NO_VALUE where there is none; `out` is NaN then. Allocates nothing from the second call on,
// except for margin, total bend and error.
int32_t cppr_solver_get(cppr_solver *solver,
                        uint32_t value,
                        double *out,
                        size_t count);

// Writes a field (cppr_field) of the last equilibrium at `sections` labels, section by section into `out`, which has room for exactly `count`
// numbers. Labels are rest abscissae of the leader, or for a robot of parts and joints lengths of the centreline, from 0 to CPPR_VALUE_LENGTH (m). Allocates.
int32_t cppr_solver_get_field(cppr_solver *solver,
                              uint32_t field,
                              const double *labels,
                              size_t sections,
                              double *out,
                              size_t count);

// How the last solve ended, in one or more sentences, UTF-8; for one without equilibrium, why and what to do. Valid until the next
// failure or explanation in this thread. Allocates.
const char *cppr_solver_explain(const cppr_solver *solver);

// What of the command would bend or turn the robot by several turns and so looks like a mistaken unit (90 for 90°): a sentence, valid as
// that of cppr_solver_explain(), or null where there is none. Allocates.
const char *cppr_solver_doubt(const cppr_solver *solver);

// Solves many poses of a robot and reads every one. Command and options of `solver` are common to all; its equilibrium is neither used nor
// changed, and it may be used meanwhile.
//
// What varies are `columns` inputs (cppr_input), each of a tube (0 on the tip); `values` has one row of `columns` numbers for each
// of `poses` poses. What is read are `wanted` values (cppr_value); `out` has room for exactly `count` numbers: one row per pose, the values
// one after another as long as cppr_solver_size() says. What a pose has not, because it has no equilibrium, is NaN: read CPPR_VALUE_STATUS first.
//
// `start` is a cppr_start. `threads` is how many threads to solve on; 0 takes one per core. The numbers do not depend on it. A
// command that cannot be asked is refused before anything is solved; the text names the pose, counted from 0.
int32_t cppr_solve_many(const cppr_solver *solver,
                        uint32_t start,
                        size_t poses,
                        size_t columns,
                        const uint32_t *inputs,
                        const uint32_t *tubes,
                        const double *values,
                        size_t wanted,
                        const uint32_t *wanted_values,
                        double *out,
                        size_t count,
                        size_t threads);

// Finds how few modes some poses bear with, for a loop that moves between them: those at the ends of what it moves through, for example. Every one, solved from rest, has its tip
// within `accuracy` times the length with so many, and is as stable as with the usual ones; where none fewer suffice, it is 1 or, where more are needed, 2 or 4. CPPR_OPTION_REFINE
// is set to it, and `refine` is the number. Forces and derivatives become coarser with the tip.
//
// Poses are given as to cppr_solve_many(). CPPR_CODE_NO_EQUILIBRIUM where no error is known, as in the formulation printed in the paper; CPPR_CODE_BAD_ARGUMENT for a robot of parts and
// joints, which has no modes. Takes some tens of milliseconds per pose, and allocates.
int32_t cppr_solver_fewest_modes(cppr_solver *solver,
                                 double accuracy,
                                 size_t poses,
                                 size_t columns,
                                 const uint32_t *inputs,
                                 const uint32_t *tubes,
                                 const double *values,
                                 double *refine);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CPPR_H */
