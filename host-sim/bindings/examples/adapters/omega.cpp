// omega.3, delta.3 and sigma.7 through Force Dimension's DHD. UNTESTED ON A DEVICE: it compiles against our stub of the
// header. With the SDK in $DHD, and a profile of your own for a delta or sigma:
// c++ -std=c++17 omega.cpp -I../../include -I$DHD/include ../../../../target/release/libpalpate_c.a -L$DHD/lib -ldhd -lpthread -ldl -lm
// ./a.out [SCENE [PROFILE]]
#include <dhdc.h>

#include "adapter.h"

int main(int argc, char **argv) {
    palpate_session session;
    palpate_info info;
    if (!opened(argc > 1 ? argv[1] : "block", argc > 2 ? argv[2] : "omega3", &session, &info)) return 1;
    if (dhdOpen() < 0 || dhdEnableForce(DHD_ON, -1) < 0) {
        std::fprintf(stderr, "omega3: %s\n", dhdErrorGetLastStr());
        return 1;
    }
    std::puts("omega3: Ctrl-C ends");
    palpate_code code = PALPATE_CODE_OK;
    for (Pace pace; code == PALPATE_CODE_OK && continues([&] { palpate_stop(session); });) {
        pace.wait();
        palpate_input input = {};
        // DHD's frame: metres; x to the operator, y right, z up, as in the scene
        input.sensor_failed = dhdGetPosition(&input.tip_m[0], &input.tip_m[1], &input.tip_m[2], -1) < 0;
        for (int k = 0; k < 3; k++) input.tip_m[k] += info.site_m[k];
        input.late_ticks = pace.late_ticks();
        double force_n[3];
        code = palpate_tick_with(session, &input, sizeof input, force_n);
        if (dhdSetForce(force_n[0], force_n[1], force_n[2], -1) < 0) break;
    }
    dhdSetForce(0.0, 0.0, 0.0, -1);
    dhdClose(-1);
    return reported("omega3", session, code);
}
