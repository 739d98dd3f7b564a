// Touch, Touch X and Omni through OpenHaptics' HD API. UNTESTED ON A DEVICE: it compiles against our stub of the
// header. The guide's page on OpenHaptics has the command; ./touch [SCENE [PROFILE]]
#include <HD/hd.h>

#include <atomic>
#include <thread>

#include "adapter.h"

struct Servo {
    HHD device;
    palpate_session session;
    palpate_info info;
    std::atomic<int> code;
    Pace pace;
};

// Called by the HD scheduler a thousand times per second. HD's frame: millimetres; x right, y up, z to the operator.
static HDCallbackCode HDCALLBACK servo(void *data) {
    Servo &servo = *static_cast<Servo *>(data);
    HDdouble hd_mm[3] = {}, hd_n[3];
    hdBeginFrame(servo.device);
    hdGetDoublev(HD_CURRENT_POSITION, hd_mm);
    const double turned_mm[3] = {hd_mm[2], hd_mm[0], hd_mm[1]}; // x to the operator, y right, z up
    palpate_input input = {};
    for (int k = 0; k < 3; k++) input.tip_m[k] = 1e-3 * turned_mm[k] + servo.info.site_m[k];
    const HDErrorInfo error = hdGetError();
    input.sensor_failed = HD_DEVICE_ERROR(error);
    input.late_ticks = servo.pace.late_ticks();
    double force_n[3];
    servo.code = palpate_tick_with(servo.session, &input, sizeof input, force_n);
    hd_n[0] = force_n[1], hd_n[1] = force_n[2], hd_n[2] = force_n[0]; // zero on a fault
    hdSetDoublev(HD_CURRENT_FORCE, hd_n);
    hdEndFrame(servo.device);
    return HD_CALLBACK_CONTINUE;
}

int main(int argc, char **argv) {
    using std::chrono::milliseconds;
    Servo own = {};
    if (!opened(argc > 1 ? argv[1] : "block", argc > 2 ? argv[2] : "touch", &own.session, &own.info)) return 1;
    own.device = hdInitDevice(HD_DEFAULT_DEVICE);
    if (own.device == HD_INVALID_HANDLE) {
        std::fprintf(stderr, "touch: no device: pair it with the vendor's setup tool first\n");
        return 1;
    }
    hdEnable(HD_FORCE_OUTPUT);
    std::puts("touch: Ctrl-C ends; lift the stylus out of the tissue, then press");
    own.pace = Pace();
    const HDSchedulerHandle handle = hdScheduleAsynchronous(servo, &own, HD_MAX_SCHEDULER_PRIORITY);
    hdStartScheduler();
    while (goes_on && own.code == PALPATE_CODE_OK) std::this_thread::sleep_for(milliseconds(10));
    const int code = own.code;
    while (palpate_stop(own.session) == PALPATE_CODE_BUSY) {} // a tick is running and will end soon
    std::this_thread::sleep_for(milliseconds(200));            // while the force is ramped down
    hdStopScheduler();
    hdUnschedule(handle);
    hdDisableDevice(own.device);
    return reported("touch", own.session, code);
}
