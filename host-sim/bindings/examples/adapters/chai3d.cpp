// Any device that CHAI3D drives. UNTESTED ON A DEVICE: it compiles against our stub of the header. With CHAI3D 3:
// c++ -std=c++17 chai3d.cpp -I../../include -I$CHAI3D/src -lpalpate_c -lchai3d; ./chai3d [PROFILE [SCENE]]
// Your own program has a window and a frame loop in the place of `redraw` here.
#include "chai3d_tissue.h"

int main(int argc, char **argv) {
    const char *profile = argc > 1 ? argv[1] : "touch";
    PalpateTissue tissue; // an object of your world: world->addChild(&tissue)
    if (!tissue.open(argc > 2 ? argv[2] : "block", profile)) return 1;
    chai3d::cHapticDeviceHandler handler;
    chai3d::cGenericHapticDevicePtr device;
    if (!handler.getDevice(device, 0) || !device->open() || !device->calibrate()) {
        std::fprintf(stderr, "chai3d: no device\n");
        return 1;
    }
    std::puts("chai3d: Ctrl-C ends");
    palpate_code code = PALPATE_CODE_OK;
    for (Pace pace; goes_on && code == PALPATE_CODE_OK;) {
        pace.wait();
        code = tissue.tick(*device, pace.late_ticks());
    }
    device->setForce(chai3d::cVector3d(0.0, 0.0, 0.0));
    device->close();
    tissue.redraw();
    return tissue.close("chai3d", code);
}
