// A press through the object of a CHAI3D world, with a device of our own. Prints position and force of every tick, and at
// the deepest point what the mesh shows: vertices, triangles, and the sum of squares of the heights.
#include "chai3d_tissue.h"

#include <algorithm>

class Stylus : public chai3d::cGenericHapticDevice {
    chai3d::cVector3d tip_m;

public:
    int tick = 0;
    bool getPosition(chai3d::cVector3d &position_m) override {
        tip_m = chai3d::cVector3d(1e-3, 2e-3, 5e-3 - 1e-5 * std::max(tick++ - 700, 0));
        position_m = tip_m;
        return true;
    }
    bool setForceAndTorqueAndGripperForce(const chai3d::cVector3d &force, const chai3d::cVector3d &, double) override {
        std::printf("%.17g %.17g %.17g %.9g %.9g %.9g\n", tip_m.x(), tip_m.y(), tip_m.z(), force.x(), force.y(), force.z());
        return true;
    }
};

int main() {
    PalpateTissue tissue;
    if (!tissue.open("block", "touch")) return 1;
    Stylus stylus;
    palpate_code code = PALPATE_CODE_OK;
    for (int tick = 0; tick < 1600 && !code; tick++) code = tissue.tick(stylus, 0);
    tissue.redraw();
    const std::vector<chai3d::cVector3d> &shown = tissue.m_vertices->positions;
    double sum = 0.0;
    for (const chai3d::cVector3d &v : shown) sum += v.z() * v.z();
    std::printf("%zu %u %.17g\n", shown.size(), tissue.triangles, sum);
    return code;
}
