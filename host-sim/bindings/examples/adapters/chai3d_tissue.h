// A soft tissue as an object of a CHAI3D world. UNTESTED WITH CHAI3D: it compiles and runs against our stub of the interface.
// Add it with world->addChild, call `tick` in the haptics thread and `redraw` before each frame. Its origin, which is also
// the device's centre, is the site of the press; CHAI3D's axes are those of the scene.
#pragma once
#include <chai3d.h>

#include <atomic>
#include <mutex>
#include <vector>

#include "adapter.h"

class PalpateTissue : public chai3d::cMesh {
    palpate_session session = 0;
    palpate_info info = {};
    std::vector<double> nodes_m;
    std::mutex copied; // held while the nodes are copied from the session or to the mesh
    unsigned int ticks = 0;
    using Call = palpate_code (*)(palpate_session);
    std::atomic<Call> asked{nullptr}; // passed on by the next tick

    double from_site_m(std::size_t k) const { return nodes_m[k] - info.site_m[k % 3]; }

public:
    // The scene and the profile of the device, by name or file. False if one cannot be used: the reason is printed.
    bool open(const char *scene, const char *profile) {
        if (!opened(scene, profile, &session, &info)) return false;
        nodes_m.resize(3 * info.nodes);
        std::vector<std::uint32_t> corners(3 * info.triangles);
        palpate_read_nodes(session, nodes_m.data(), nodes_m.size());
        palpate_read_triangles(session, corners.data(), corners.size());
        for (std::size_t n = 0; n < nodes_m.size(); n += 3) newVertex(from_site_m(n), from_site_m(n + 1), from_site_m(n + 2));
        for (std::size_t k = 0; k < corners.size(); k += 3) newTriangle(corners[k], corners[k + 1], corners[k + 2]);
        computeAllNormals();
        return true;
    }

    // Requests from any thread. After a fault: clear, then arm a moment later.
    void arm() { asked = palpate_arm; }
    void stop() { asked = palpate_stop; }
    void clear() { asked = palpate_clear; }

    // One tick of 1 ms: reads the device and sends it the force, which is zero unless PALPATE_CODE_OK is returned.
    palpate_code tick(chai3d::cGenericHapticDevice &device, std::uint32_t late_ticks) {
        chai3d::cVector3d tip_m;
        palpate_input input = {};
        input.sensor_failed = !device.getPosition(tip_m);
        input.tip_m[0] = tip_m.x() + info.site_m[0];
        input.tip_m[1] = tip_m.y() + info.site_m[1];
        input.tip_m[2] = tip_m.z() + info.site_m[2];
        input.late_ticks = late_ticks;
        chai3d::cMatrix3d rotation; // from the upright pose; a device without one leaves the probe as it is
        if (device.getRotation(rotation)) {
            chai3d::cQuaternion turn;
            turn.fromRotMat(rotation);
            const double orientation[4] = {turn.x, turn.y, turn.z, turn.w};
            palpate_turn(session, orientation); // refused beyond 45 degrees: the probe then stays
        }
        if (const Call call = asked.exchange(nullptr)) call(session);
        double force_n[3];
        const palpate_code code = palpate_tick_with(session, &input, sizeof input, force_n);
        device.setForce(chai3d::cVector3d(force_n[0], force_n[1], force_n[2]));
        // copied here, because a session answers one thread at a time; a tick never waits for a frame
        if (++ticks % 16 == 0 && copied.try_lock()) {
            palpate_read_nodes(session, nodes_m.data(), nodes_m.size());
            copied.unlock();
        }
        return code;
    }

    // Moves the vertices to the nodes' last copy: at most 16 ms old.
    void redraw() {
        const std::lock_guard<std::mutex> lock(copied);
        for (std::size_t n = 0; n < nodes_m.size(); n += 3)
            m_vertices->setLocalPos(static_cast<unsigned int>(n / 3), from_site_m(n), from_site_m(n + 1), from_site_m(n + 2));
        computeAllNormals();
        markForUpdate(false);
    }

    // Ends the session; prints why the ticks ended, and returns the exit code. Set the device's force to zero first.
    int close(const char *name, palpate_code code) { return reported(name, session, code); }
};
