// OUR STUB of the few declarations of Haply's HardwareAPI that inverse3.cpp needs, written from public uses of it, so
// that the adapter compiles in the tests. Not the vendor's header: build against theirs.
#pragma once
#include <cstdint>

namespace Haply::HardwareAPI {
namespace IO {
class SerialStream {
public:
    explicit SerialStream(const char *port);
};
} // namespace IO
namespace Devices {
class Inverse3 {
public:
    struct DeviceInfoResponse { std::uint16_t device_id; };
    struct EndEffectorForceRequest { float force[3]; };
    struct EndEffectorStateResponse { float position[3]; float velocity[3]; };
    explicit Inverse3(IO::SerialStream *stream);
    DeviceInfoResponse DeviceWakeup();
    EndEffectorStateResponse EndEffectorForce(const EndEffectorForceRequest &request, bool on_board_gravity_compensation);
};
} // namespace Devices
} // namespace Haply::HardwareAPI
