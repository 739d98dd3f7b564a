// Inverse3 on its serial port, through Haply's HardwareAPI, which implements the protocol: one exchange sends a
// force and returns a position. UNTESTED ON A DEVICE: it compiles against our stub of the header.
// With the SDK: c++ -std=c++17 inverse3.cpp -I../../include -lpalpate_c -lHaplyHardwareAPI
#include <HardwareAPI.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

#include "palpate.h"

static volatile std::sig_atomic_t goes_on = 1;
static void end(int) { goes_on = 0; }

int main(int argc, char **argv) {
    using Haply::HardwareAPI::Devices::Inverse3;
    using std::chrono::milliseconds;
    using Clock = std::chrono::steady_clock;
    palpate_session session;
    palpate_info info;
    if (palpate_open_scene("block", nullptr, "inverse3", &session) || palpate_arm(session) ||
        palpate_read_info(session, &info, sizeof info)) {
        std::fprintf(stderr, "inverse3: %s\n", palpate_last_message());
        return 1;
    }
    Haply::HardwareAPI::IO::SerialStream stream(argc > 1 ? argv[1] : "/dev/ttyACM0");
    Inverse3 device(&stream);
    device.DeviceWakeup();
    std::signal(SIGINT, end);
    Inverse3::EndEffectorForceRequest request = {};
    // Haply's frame: metres; x right, y away from the operator, z up, origin in the base. The pose at the start is
    // taken as the centre.
    const auto start = device.EndEffectorForce(request, true);
    palpate_code code = PALPATE_CODE_OK;
    for (auto next = Clock::now(); goes_on && code == PALPATE_CODE_OK;) {
        std::this_thread::sleep_until(next += milliseconds(1));
        const auto state = device.EndEffectorForce(request, true);
        double way_m[3], force_n[3];
        for (int k = 0; k < 3; k++) way_m[k] = double(state.position[k]) - double(start.position[k]);
        palpate_input input = {};
        const double turned_m[3] = {-way_m[1], way_m[0], way_m[2]}; // x to the operator, y right, z up
        for (int k = 0; k < 3; k++) input.tip_m[k] = turned_m[k] + info.site_m[k];
        input.tip_m[2] += 0.02; // the centre is 20 mm above the tissue
        const auto late = (Clock::now() - next) / milliseconds(1);
        input.late_ticks = static_cast<std::uint32_t>(late);
        next += late * milliseconds(1);
        code = palpate_tick_with(session, &input, sizeof input, force_n);
        const double turned_n[3] = {force_n[1], -force_n[0], force_n[2]};
        for (int k = 0; k < 3; k++) request.force[k] = static_cast<float>(turned_n[k]);
    }
    request = {};
    device.EndEffectorForce(request, true);
    std::printf("inverse3: %s\n", code ? palpate_last_message() : "ended");
    palpate_close(session);
    return code != PALPATE_CODE_OK;
}
