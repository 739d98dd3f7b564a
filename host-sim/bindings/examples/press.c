/* A press at 10 mm/s, from 5 mm above the site to 4 mm below it and back; prints a line every tenth of a second. */
#include <stdio.h>

#include "palpate.h"

static int failed(const char *what) {
    fprintf(stderr, "%s: %s\n", what, palpate_last_message());
    return 1;
}

int main(int argc, char **argv) {
    const char *scene = argc > 1 ? argv[1] : "block", *patch = argc > 2 ? argv[2] : NULL;
    palpate_session session;
    palpate_info info;
    if (palpate_open_scene(scene, patch, "touch", &session)) return failed("open");
    if (palpate_read_info(session, &info, sizeof info) || palpate_arm(session)) return failed("arm");
    for (int tick = 0; tick < 2500; tick++) {
        /* the probe stays above the tissue until the force is ready, which takes 0.7 s */
        int steps = tick < 700 ? 0 : tick < 1600 ? tick - 700 : 2500 - tick;
        double depth_m = 1e-5 * steps - 5e-3;
        double tip_m[3], force_n[3];
        for (int k = 0; k < 3; k++) tip_m[k] = info.site_m[k] - info.axis[k] * depth_m;
        if (palpate_tick(session, tip_m, force_n)) return failed("tick");
        if (tick % 100 == 99)
            printf("%d ms %.3f mm %.9g %.9g %.9g N\n", tick + 1, depth_m * 1e3, force_n[0], force_n[1], force_n[2]);
    }
    return palpate_close(session) ? failed("close") : 0;
}
