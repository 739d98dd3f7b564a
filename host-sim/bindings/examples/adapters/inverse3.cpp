// Inverse3 on its serial port, through Haply's HardwareAPI, which implements the protocol: one exchange sends a
// force and returns a position. UNTESTED ON A DEVICE: it compiles against our stub of the header.
// With the SDK in $HAPLY:
// c++ -std=c++17 inverse3.cpp -I../../include -I$HAPLY/include ../../../../target/release/libpalpate_c.a -L$HAPLY/lib -lHaplyHardwareAPI -lpthread -ldl -lm
// ./a.out [PORT [SCENE [PROFILE]]]
#include <HardwareAPI.h>

#include "adapter.h"

int main(int argc, char **argv) {
    using Haply::HardwareAPI::Devices::Inverse3;
    palpate_session session;
    palpate_info info;
    if (!opened(argc > 2 ? argv[2] : "block", argc > 3 ? argv[3] : "inverse3", &session, &info)) return 1;
    Haply::HardwareAPI::IO::SerialStream stream(argc > 1 ? argv[1] : "/dev/ttyACM0");
    Inverse3 device(&stream);
    device.DeviceWakeup();
    std::puts("inverse3: Ctrl-C ends");
    Inverse3::EndEffectorForceRequest request = {};
    // Haply's frame: metres; x right, y away from the operator, z up, origin in the base. The pose at the start is
    // taken as the centre.
    const auto start = device.EndEffectorForce(request, true);
    palpate_code code = PALPATE_CODE_OK;
    for (Pace pace; code == PALPATE_CODE_OK && continues([&] { palpate_stop(session); });) {
        pace.wait();
        const auto state = device.EndEffectorForce(request, true);
        double way_m[3], force_n[3];
        for (int k = 0; k < 3; k++) way_m[k] = double(state.position[k]) - double(start.position[k]);
        palpate_input input = {};
        const double turned_m[3] = {-way_m[1], way_m[0], way_m[2]}; // x to the operator, y right, z up
        for (int k = 0; k < 3; k++) input.tip_m[k] = turned_m[k] + info.site_m[k];
        input.tip_m[2] += 0.02; // the centre is 20 mm above the tissue
        input.late_ticks = pace.late_ticks();
        code = palpate_tick_with(session, &input, sizeof input, force_n);
        const double turned_n[3] = {force_n[1], -force_n[0], force_n[2]};
        for (int k = 0; k < 3; k++) request.force[k] = static_cast<float>(turned_n[k]);
    }
    request = {};
    device.EndEffectorForce(request, true);
    return reported("inverse3", session, code);
}
