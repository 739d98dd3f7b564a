// Any device that CHAI3D drives. UNTESTED ON A DEVICE: it compiles against the headers of CHAI3D 3.3.0, and was linked with
// our stub. With CHAI3D in $CHAI3D, built by its Makefile:
// c++ -std=c++17 -DLINUX chai3d.cpp -I../../include -I$CHAI3D/src -I$CHAI3D/externals/Eigen -I$CHAI3D/externals/glew/include
//     ../../../../target/release/libpalpate_c.a -L$CHAI3D/lib/release/lin-x86_64-cc -lchai3d
//     -L$CHAI3D/externals/DHD/lib/lin-x86_64 -ldrd -lGL -lGLU -lusb-1.0 -lasound -lpthread -ldl -lm
// ./a.out [SCENE [PROFILE]]
// Your own program has a window and a frame loop in the place of `redraw` here.
#include "chai3d_tissue.h"

int main(int argc, char **argv) {
    const char *profile = argc > 2 ? argv[2] : "touch";
    PalpateTissue tissue; // an object of your world: world->addChild(&tissue)
    if (!tissue.open(argc > 1 ? argv[1] : "block", profile)) return 1;
    chai3d::cHapticDeviceHandler handler;
    chai3d::cGenericHapticDevicePtr device;
    if (!handler.getDevice(device, 0) || !device->open() || !device->calibrate()) {
        std::fprintf(stderr, "chai3d: no device\n");
        return 1;
    }
    std::puts("chai3d: Ctrl-C ends");
    palpate_code code = PALPATE_CODE_OK;
    for (Pace pace; code == PALPATE_CODE_OK && continues([&] { tissue.stop(); });) {
        pace.wait();
        code = tissue.tick(*device, pace.late_ticks());
    }
    device->setForce(chai3d::cVector3d(0.0, 0.0, 0.0));
    device->close();
    tissue.redraw();
    return tissue.close("chai3d", code);
}
