// A clock that a fake device library advances, and every look at it by a microsecond.
#pragma once
#include <atomic>
#include <chrono>

extern std::atomic<long long> fake_us;

struct FakeClock {
    using duration = std::chrono::microseconds;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<FakeClock>;
    static constexpr bool is_steady = true;
    static time_point now() { return time_point(duration(++fake_us)); }
};
