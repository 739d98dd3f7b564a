// A servo callback like those of CHAI3D and OpenHaptics: the driver calls it a thousand times per second, and it
// reads a position and sets a force. The device is a fake: a stylus of 45 g in a hand that pushes it 3 mm into
// the tissue and out again. "fast" runs without waiting; "trace" prints position and force of every tick.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>

#include "palpate.h"

// Takes the place of the vendor's device: metres and newtons, z up, its centre at the origin.
class FakeDevice {
public:
    void getPosition(double position_m[3]) const { position_m[0] = position_m[1] = 0.0, position_m[2] = z_m; }
    void setForce(const double force_n[3]) { felt_n = force_n[2]; }
    void step(int tick) {
        const double depth_m = tick < 700 ? -1e-3 : 4e-3 * std::sin(2e-3 * (tick - 700)) - 1e-3; // target of the hand
        const double hand_n = 300.0 * (-depth_m - z_m) - 5.0 * speed_m_per_s;
        speed_m_per_s += 1e-3 * (hand_n + felt_n) / 0.045;
        z_m += 1e-3 * speed_m_per_s;
    }

private:
    double z_m = 1e-3, speed_m_per_s = 0.0, felt_n = 0.0;
};

// Everything that the callback uses; none of it allocates, locks or prints.
struct Servo {
    FakeDevice device;
    palpate_session session = 0;
    palpate_info info = {};
    double tip_m[3] = {}, force_n[3] = {};
    palpate_code code = PALPATE_CODE_OK;
};

// Called once per millisecond, in the driver's thread of highest priority. Where the driver may be late, count the periods
// that passed as `adapters/adapter.h` does, and call palpate_tick_with.
static void servo(Servo &servo) {
    servo.device.getPosition(servo.tip_m);
    for (int k = 0; k < 3; k++) servo.tip_m[k] += servo.info.site_m[k]; // the device's centre is at the site
    servo.code = palpate_tick(servo.session, servo.tip_m, servo.force_n);
    servo.device.setForce(servo.force_n); // zero if the tick failed
}

int main(int argc, char **argv) {
    bool fast = false, trace = false;
    for (int n = 1; n < argc; n++) fast |= !std::strcmp(argv[n], "fast"), trace |= !std::strcmp(argv[n], "trace");
    Servo own;
    if (palpate_open_scene("block", nullptr, "touch", &own.session) || palpate_arm(own.session) ||
        palpate_read_info(own.session, &own.info, sizeof own.info)) {
        std::fprintf(stderr, "servo: %s\n", palpate_last_message());
        return 1;
    }
    auto next = std::chrono::steady_clock::now();
    for (int tick = 0; tick < 2500 && own.code == PALPATE_CODE_OK; tick++) {
        own.device.step(tick);
        servo(own);
        const double *tip_m = own.tip_m, *force_n = own.force_n;
        if (trace) std::printf("%.17g %.17g %.17g %.9g %.9g %.9g\n", tip_m[0], tip_m[1], tip_m[2], force_n[0], force_n[1], force_n[2]);
        if (!trace && tick % 250 == 249) std::printf("%4d ms: %6.3f mm, %.4f N\n", tick + 1, tip_m[2] * 1e3, force_n[2]);
        if (!fast) std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
    }
    if (own.code) std::fprintf(stderr, "servo: %s\n", palpate_last_message());
    palpate_close(own.session);
    return own.code != PALPATE_CODE_OK;
}
