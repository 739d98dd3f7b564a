// The part of CHAI3D 3's interface that the adapter uses, so that it compiles without it. Written from its shape: no code of
// CHAI3D is here, and nothing is drawn.
#pragma once
#include <cmath>
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

class cMatrix3d {
    double m_rows[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

public:
    double &operator()(int row, int column) { return m_rows[row][column]; }
    double operator()(int row, int column) const { return m_rows[row][column]; }
};

struct cQuaternion {
    double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
    // by a rotation of less than 180 degrees
    void fromRotMat(const cMatrix3d &m) {
        w = 0.5 * std::sqrt(1.0 + m(0, 0) + m(1, 1) + m(2, 2));
        x = (m(2, 1) - m(1, 2)) / (4.0 * w), y = (m(0, 2) - m(2, 0)) / (4.0 * w), z = (m(1, 0) - m(0, 1)) / (4.0 * w);
    }
};

// Base of every device.
class cGenericHapticDevice {
public:
    virtual ~cGenericHapticDevice() = default;
    virtual bool open() { return false; }
    virtual bool close() { return false; }
    virtual bool calibrate(bool = false) { return false; }
    virtual bool getPosition(cVector3d &) { return false; }
    virtual bool getRotation(cMatrix3d &) { return false; }
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
