/* Palpate from C and C++: README.md of host-sim/bindings shows how. Made by cbindgen from src/{code,records,ffi}.rs:
 * a test of the repository fails when it is not current. SI units; vectors are x, y, z in the frame of the scene. */

#ifndef PALPATE_H
#define PALPATE_H

#include <stddef.h>
#include <stdint.h>

/* A session by handle; 0 is none. */
typedef uint64_t palpate_session;

// Result of a call. Anything but `PALPATE_CODE_OK` has its words in `palpate_error_text`,
// and what was wrong with this very call in `palpate_last_message`.
typedef enum palpate_code {
  // Done.
  PALPATE_CODE_OK = 0,
  // A fault is latched and the force is zero: `palpate_read_report` says which.
  PALPATE_CODE_FAULT = 1,
  // A pointer is NULL that must not be.
  PALPATE_CODE_NULL = 2,
  // A text is not UTF-8.
  PALPATE_CODE_NOT_TEXT = 3,
  // A size or length does not fit.
  PALPATE_CODE_WRONG_SIZE = 4,
  // A number is outside its range.
  PALPATE_CODE_OUT_OF_RANGE = 5,
  // The handle belongs to no open session.
  PALPATE_CODE_NO_SESSION = 6,
  // Another thread is in a call with this session.
  PALPATE_CODE_BUSY = 7,
  // The session's state does not allow this call.
  PALPATE_CODE_WRONG_ORDER = 8,
  // As many sessions are open as can be.
  PALPATE_CODE_TOO_MANY = 9,
  // A file cannot be read.
  PALPATE_CODE_CANNOT_READ = 10,
  // A scene, mesh or device profile cannot be used.
  PALPATE_CODE_BAD_SCENE = 11,
  // A patch file cannot be used.
  PALPATE_CODE_BAD_PATCH = 12,
  // The tissue cannot keep 1 kHz.
  PALPATE_CODE_TOO_SLOW = 13,
  // A defect of the library; the session was closed.
  PALPATE_CODE_INTERNAL = 14,
} palpate_code;

// Operating mode. Force acts in `PALPATE_MODE_ACTIVE`, `PALPATE_MODE_DEGRADED` and, falling, in
// `PALPATE_MODE_SAFE_RAMP`.
typedef enum palpate_mode {
  // Before the first tick.
  PALPATE_MODE_BOOT = 0,
  // The first tick.
  PALPATE_MODE_SELF_TEST = 1,
  // Waits for `palpate_arm`.
  PALPATE_MODE_IDLE = 2,
  // Waits for a calm probe outside the tissue.
  PALPATE_MODE_ARMING = 3,
  // The force is felt.
  PALPATE_MODE_ACTIVE = 4,
  // The force is felt, scaled down for the rest of this contact.
  PALPATE_MODE_DEGRADED = 5,
  // The force is felt while it falls to zero.
  PALPATE_MODE_SAFE_RAMP = 6,
  // No force until `palpate_clear`.
  PALPATE_MODE_FAULT = 7,
} palpate_mode;

// Input of `palpate_tick_with`: all zero but for the position is a new, good reading in time.
typedef struct palpate_input {
  // Tip of the probe [m].
  double tip_m[3];
  // Periods of 1 ms that went by without a tick since the last tick.
  uint32_t late_ticks;
  // Not zero if the position is an old one, because no new reading came.
  uint8_t stale;
  // Not zero if the device says that its reading cannot be trusted.
  uint8_t sensor_failed;
  // Not zero if the hand switch is open: then there is no force and no arming.
  uint8_t operator_absent;
  // Zero.
  uint8_t reserved;
} palpate_input;

// Record of the last tick.
typedef struct palpate_report {
  // Tip that was rendered [m]; the last good one on a fault.
  double tip_m[3];
  // Force on the device [N].
  double force_n[3];
  // Force of the tissue before damping, gains and limits [N].
  double tissue_n[3];
  // Outward unit normal of the contact; zero without contact.
  double normal[3];
  // Depth of the tip below the undeformed surface, along the normal [m]; zero without contact.
  double depth_m;
  // Energy given to the hand since the touch [J]; negative while the tissue holds some.
  double given_j;
  // Young's modulus [Pa].
  double youngs_modulus_pa;
  // Young's modulus that waits for the probe to leave [Pa]; zero where none does.
  double waiting_modulus_pa;
  // Ticks begun, wrapping.
  uint32_t ticks;
  // A `palpate_mode`.
  int32_t mode;
  // Number of the latched fault, for `palpate_fault_text`; zero without one.
  int32_t fault;
  // Limits that acted: 1 speed, 2 depth, 4 force, 8 started inside the tissue, 16 slew, 32 held
  // reading, 64 gain, 128 energy.
  uint32_t limiters;
  // 1 while the probe touches the tissue.
  uint8_t contact;
  // 1 if the tick refused what was asked: too early, or not in this mode.
  uint8_t refused;
  // Zero.
  uint8_t reserved[6];
} palpate_report;

// Tissue, probe and device of a session.
typedef struct palpate_info {
  // Site of the press on the rest surface [m]: put your device's centre there.
  double site_m[3];
  // Unit vector out of the tissue at the site.
  double axis[3];
  // Corner of the device's workspace with the smallest coordinates [m].
  double workspace_low_m[3];
  // Corner with the largest [m].
  double workspace_high_m[3];
  // Radius of the probe [m].
  double probe_radius_m;
  // Deepest press that the patch is shown [m].
  double depth_limit_m;
  // Maximum force of the loop [N].
  double max_force_n;
  // Young's modulus [Pa].
  double youngs_modulus_pa;
  // Nodes of the patch.
  uint64_t nodes;
  // Surface triangles of the patch.
  uint64_t triangles;
} palpate_info;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Opens a scene: a preset's name or the path of a scene file. `patch` is the path of a patch file
// in place of the scene's own, or NULL. `device` is a profile's name or the path of a .toml file;
// NULL stands for "touch". Takes up to seconds, and memory: no tick does. `session` gets the
// handle, 0 on failure.
//
// # Safety
// Texts end with a zero byte; `session` points to one handle.
enum palpate_code palpate_open_scene(const char *scene,
                                     const char *patch,
                                     const char *device,
                                     palpate_session *session);

// Opens a patch file alone: tissue, probe and site are those that it was packed with. `device` and
// `session` as in `palpate_open_scene`.
//
// # Safety
// Texts end with a zero byte; `session` points to one handle.
enum palpate_code palpate_open_patch(const char *path, const char *device, palpate_session *session);

// As `palpate_open_patch`, of the file's bytes, which are not needed after the call.
//
// # Safety
// `bytes` points to `length` bytes; texts end with a zero byte; `session` points to one handle.
enum palpate_code palpate_open_patch_bytes(const uint8_t *bytes,
                                           size_t length,
                                           const char *device,
                                           palpate_session *session);

// Closes a session and frees its memory. The device keeps its last force: give it zero first.
enum palpate_code palpate_close(palpate_session session);

// One tick: tip of the probe [m], scene frame, x y z, to force on the device [N]. Call it every
// millisecond. `force_n` is zero on every failure; with a NULL `tip_m` the sensor counts as failed
// and the fault is latched. `PALPATE_CODE_FAULT` is returned while a fault is latched.
//
// # Safety
// `tip_m` and `force_n` point to three doubles each.
enum palpate_code palpate_tick(palpate_session session, const double *tip_m, double *force_n);

// As `palpate_tick`, for devices that know more of a reading than its position. `input_bytes` is
// `sizeof(palpate_input)`.
//
// # Safety
// `input` points to that many bytes, `force_n` to three doubles.
enum palpate_code palpate_tick_with(palpate_session session,
                                    const struct palpate_input *input,
                                    size_t input_bytes,
                                    double *force_n);

// Record of the last tick. `report_bytes` is `sizeof(palpate_report)`.
//
// # Safety
// `report` points to that many bytes.
enum palpate_code palpate_read_report(palpate_session session,
                                      struct palpate_report *report,
                                      size_t report_bytes);

// Tissue, probe and device. `info_bytes` is `sizeof(palpate_info)`.
//
// # Safety
// `info` points to that many bytes.
enum palpate_code palpate_read_info(palpate_session session, struct palpate_info *info, size_t info_bytes);

// Positions of all nodes [m], x y z after each other, for drawing. `capacity` is the number of
// doubles that `positions_m` holds, at least three times `palpate_info.nodes`.
//
// # Safety
// `positions_m` points to that many doubles.
enum palpate_code palpate_read_nodes(palpate_session session, double *positions_m, size_t capacity);

// Hash of all positions and velocities of the tissue: equal on every machine after the same ticks.
//
// # Safety
// `hash` points to one number.
enum palpate_code palpate_state_hash(palpate_session session, uint64_t *hash);

// Asks for a force. It comes once the probe has been outside the tissue and calm for a tenth of a
// second, and grows for half a second in free space.
enum palpate_code palpate_arm(palpate_session session);

// Lets the force fall to nothing within an eighth of a second of ticks, and disarms.
enum palpate_code palpate_stop(palpate_session session);

// Asks the next tick to forget the fault; refused, as the report says, until readings have been
// good for a tenth of a second. Arm again afterwards.
enum palpate_code palpate_clear(palpate_session session);

// Starts anew: tissue at rest, no force, no fault, not armed. Modulus and lowered limits stay.
enum palpate_code palpate_reset(palpate_session session);

// Sets Young's modulus [Pa], between half and twice the one that was opened. A stiffer one waits
// until the probe does not touch.
enum palpate_code palpate_set_modulus(palpate_session session, double youngs_modulus_pa);

// Lowers the maximum force [N], for good; no limit can be raised or switched off.
enum palpate_code palpate_lower_force(palpate_session session, double max_force_n);

// A code in words; never NULL.
const char *palpate_error_text(int32_t code);

// A mode in words; never NULL.
const char *palpate_mode_text(int32_t mode);

// A fault of a report in words; never NULL.
const char *palpate_fault_text(int32_t fault);

// Says in one line why the last failed call of this thread failed; empty if none has failed.
// Never NULL; valid in this thread, until its next call that fails.
const char *palpate_last_message(void);

// Version of the library, such as "0.1.0".
const char *palpate_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* PALPATE_H */
