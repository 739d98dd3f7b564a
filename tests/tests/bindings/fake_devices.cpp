// A device library in place of the vendors', behind all four stubs, with a clock of its own. The stylus presses slowly;
// at tick 1500, 3 mm deep, it does as FAKE says: "late", "stops" or "jumps"; anything else goes on to the end, where it
// raises SIGINT as Ctrl-C does. Prints the largest force before tick 1500, and after tick 1510.
#include "fake_clock.h"

#include <HD/hd.h>
#include <HardwareAPI.h>
#include <chai3d.h>
#include <dhdc.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

std::atomic<long long> fake_us{0};

static int tick = 0;
static double before_n = 0.0, after_n = 0.0;

static bool is(const char *what) {
    const char *fake = std::getenv("FAKE");
    return fake && std::string(fake) == what;
}

// Height of the tip above the tissue [m]; one call per tick.
static double height_m() {
    tick++;
    if (tick >= 1500 && is("late")) fake_us += 5000;
    if (tick == 2500) std::raise(SIGINT);
    const int steps = tick < 700 ? 0 : std::min(tick - 700, 2500 - tick);
    return 5e-3 - 1e-5 * std::max(steps, 0) + (tick >= 1500 && is("jumps") ? 0.04 : 0.0);
}

static bool stopped() { return tick >= 1500 && is("stops"); }

static void felt(double x, double y, double z) {
    const double n = std::sqrt(x * x + y * y + z * z);
    if (tick < 1500) before_n = std::max(before_n, n);
    if (tick > 1510) after_n = std::max(after_n, n);
}

static void printed() { std::printf("before %.3f N, after %.3f N\n", before_n, after_n); }

// OpenHaptics
static HDSchedulerCallback callback;
static void *its_data;
static std::atomic<bool> runs{false};
static std::thread scheduler;
static double height_mm;
HHD hdInitDevice(const char *) { return 0; }
void hdDisableDevice(HHD) { printed(); }
void hdEnable(HDenum) {}
void hdBeginFrame(HHD) { height_mm = 1e3 * height_m(); }
void hdEndFrame(HHD) {}
void hdGetDoublev(HDenum, HDdouble *values) { values[0] = values[2] = 0.0, values[1] = height_mm; }
void hdSetDoublev(HDenum, const HDdouble *values) { felt(values[0], values[1], values[2]); }
HDErrorInfo hdGetError(void) { return {stopped() ? 1u : 0u, 0, 0}; }
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback own, void *data, unsigned short) {
    callback = own, its_data = data;
    return 1;
}
void hdStartScheduler(void) {
    runs = true;
    scheduler = std::thread([] {
        while (runs) {
            fake_us += 1000;
            callback(its_data);
            // the program looks for a fault every 10 ms: until then no more than these ticks
            if (tick > 1600) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    });
}
void hdStopScheduler(void) {
    runs = false;
    scheduler.join();
}
void hdUnschedule(HDSchedulerHandle) {}

// Force Dimension
int dhdOpen(void) { return 0; }
int dhdClose(char) { return printed(), 0; }
int dhdEnableForce(unsigned char, char) { return 0; }
int dhdGetPosition(double *x_m, double *y_m, double *z_m, char) {
    *x_m = *y_m = 0.0, *z_m = height_m();
    return stopped() ? -1 : 0;
}
int dhdSetForce(double x_n, double y_n, double z_n, char) { return felt(x_n, y_n, z_n), 0; }
const char *dhdErrorGetLastStr(void) { return "no error"; }
double dhdGetTime(void) { return 1e-6 * double(fake_us); }

// CHAI3D
class FakeDevice : public chai3d::cGenericHapticDevice {
    bool open() override { return true; }
    bool close() override { return printed(), true; }
    bool calibrate(bool) override { return true; }
    bool getPosition(chai3d::cVector3d &position_m) override {
        position_m = chai3d::cVector3d(0.0, 0.0, height_m());
        return !stopped();
    }
    bool setForceAndTorqueAndGripperForce(const chai3d::cVector3d &force, const chai3d::cVector3d &, double) override {
        return felt(force.x(), force.y(), force.z()), true;
    }
};
bool chai3d::cHapticDeviceHandler::getDevice(cGenericHapticDevicePtr &device, unsigned int) {
    device = std::make_shared<FakeDevice>();
    return true;
}

// Haply, whose centre is 20 mm above the tissue; a stopped device blocks the exchange
namespace Haply::HardwareAPI {
IO::SerialStream::SerialStream(const char *) {}
Devices::Inverse3::Inverse3(IO::SerialStream *) { std::atexit(printed); }
Devices::Inverse3::DeviceInfoResponse Devices::Inverse3::DeviceWakeup() { return {}; }
Devices::Inverse3::EndEffectorStateResponse Devices::Inverse3::EndEffectorForce(const EndEffectorForceRequest &request, bool) {
    felt(request.force[0], request.force[1], request.force[2]);
    static const double start_m = 5e-3;
    const double z_m = height_m() - start_m - (tick > 1 ? 0.015 : 0.0);
    if (stopped()) fake_us += 100000;
    return {{0.1f, 0.2f, static_cast<float>(0.3 + z_m)}, {}};
}
} // namespace Haply::HardwareAPI
