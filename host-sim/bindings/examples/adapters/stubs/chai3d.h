// The part of CHAI3D 3's interface that the adapter uses, so that it compiles without it. Written from its shape: no code of
// CHAI3D is here, and nothing is drawn.
#pragma once
#include <memory>
#include <vector>

namespace chai3d {
class cVector3d {
    double m_x, m_y, m_z;

public:
    cVector3d(double x = 0.0, double y = 0.0, double z = 0.0) : m_x(x), m_y(y), m_z(z) {}
    double x() const { return m_x; }
    double y() const { return m_y; }
    double z() const { return m_z; }
};

// Base of every device.
class cGenericHapticDevice {
public:
    virtual ~cGenericHapticDevice() = default;
    virtual bool open() { return false; }
    virtual bool close() { return false; }
    virtual bool calibrate(bool = false) { return false; }
    virtual bool getPosition(cVector3d &) { return false; }
    virtual bool setForceAndTorqueAndGripperForce(const cVector3d &, const cVector3d &, double) { return false; }
    bool setForce(const cVector3d &force) { return setForceAndTorqueAndGripperForce(force, cVector3d(), 0.0); }
};
using cGenericHapticDevicePtr = std::shared_ptr<cGenericHapticDevice>;

class cHapticDeviceHandler {
public:
    bool getDevice(cGenericHapticDevicePtr &device, unsigned int index = 0);
};

class cVertexArray {
public:
    std::vector<cVector3d> positions;
    void setLocalPos(unsigned int index, double x, double y, double z) { positions[index] = cVector3d(x, y, z); }
    cVector3d getLocalPos(unsigned int index) const { return positions[index]; }
};

// Base of every object of a world.
class cGenericObject {
public:
    virtual ~cGenericObject() = default;
    void markForUpdate(bool) {}
};

class cMesh : public cGenericObject {
public:
    std::shared_ptr<cVertexArray> m_vertices = std::make_shared<cVertexArray>();
    unsigned int triangles = 0;
    unsigned int newVertex(double x, double y, double z) {
        m_vertices->positions.emplace_back(x, y, z);
        return static_cast<unsigned int>(m_vertices->positions.size() - 1);
    }
    unsigned int newTriangle(unsigned int, unsigned int, unsigned int) { return triangles++; }
    void computeAllNormals() {}
};
} // namespace chai3d
