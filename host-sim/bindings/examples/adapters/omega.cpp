// omega.3, delta.3 and sigma.7 through Force Dimension's DHD. UNTESTED ON A DEVICE: it compiles against our stub of the
// header. With the SDK: c++ omega.cpp -I../../include -lpalpate_c -ldhd
#include <dhdc.h>

#include <csignal>
#include <cstdio>

#include "palpate.h"

static volatile std::sig_atomic_t goes_on = 1;
static void end(int) { goes_on = 0; }

int main() {
    palpate_session session;
    palpate_info info;
    if (palpate_open_scene("block", nullptr, "omega3", &session) || palpate_arm(session) ||
        palpate_read_info(session, &info, sizeof info)) {
        std::fprintf(stderr, "omega: %s\n", palpate_last_message());
        return 1;
    }
    if (dhdOpen() < 0 || dhdEnableForce(DHD_ON, -1) < 0) {
        std::fprintf(stderr, "omega: %s\n", dhdErrorGetLastStr());
        return 1;
    }
    std::signal(SIGINT, end);
    std::puts("omega: Ctrl-C ends");
    palpate_code code = PALPATE_CODE_OK;
    for (double next_s = dhdGetTime(); goes_on && code == PALPATE_CODE_OK; next_s += 1e-3) {
        while (dhdGetTime() < next_s) {} // busy wait in a thread of its own, as in DHD's loops
        palpate_input input = {};
        // DHD's frame: metres; x to the operator, y right, z up, as in the scene
        input.sensor_failed = dhdGetPosition(&input.tip_m[0], &input.tip_m[1], &input.tip_m[2], -1) < 0;
        for (int k = 0; k < 3; k++) input.tip_m[k] += info.site_m[k];
        const double behind_s = dhdGetTime() - next_s;
        input.late_ticks = static_cast<unsigned>(1e3 * behind_s);
        next_s += 1e-3 * input.late_ticks;
        double force_n[3];
        code = palpate_tick_with(session, &input, sizeof input, force_n);
        if (dhdSetForce(force_n[0], force_n[1], force_n[2], -1) < 0) break;
    }
    dhdSetForce(0.0, 0.0, 0.0, -1);
    dhdClose(-1);
    std::printf("omega: %s\n", code ? palpate_last_message() : "ended");
    palpate_close(session);
    return code != PALPATE_CODE_OK;
}
