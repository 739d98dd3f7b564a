// Common to the adapters: opening a session, counting late ticks, and the reason for an end.
#pragma once
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>

#include "palpate.h"

#ifndef ADAPTER_CLOCK
#define ADAPTER_CLOCK std::chrono::steady_clock // a test has a clock of its own
#endif

static volatile std::sig_atomic_t goes_on = 1; // until Ctrl-C
static void end(int) { goes_on = 0; }

// True until Ctrl-C, and then for the 200 ticks in which the force is ramped down; `stop` asks the session for that.
template <class Stop> static bool continues(Stop stop) {
    static int left = 200;
    if (goes_on) return true;
    if (left == 200) stop();
    return left-- > 0;
}

// Opens a scene for a device, arms the session, and prints what the device's profile leaves open.
static bool opened(const char *scene, const char *device, palpate_session *session, palpate_info *info) {
    char cautions[4096];
    if (palpate_open_scene(scene, nullptr, device, session) || palpate_read_info(*session, info, sizeof *info) ||
        palpate_read_cautions(*session, cautions, sizeof cautions) || palpate_arm(*session)) {
        std::fprintf(stderr, "%s: %s\n", device, palpate_last_message());
        return false;
    }
    std::fprintf(stderr, "%s%s", cautions, *cautions ? "\n" : "");
    std::signal(SIGINT, end);
    return true;
}

// Counts the milliseconds that passed without a tick.
class Pace {
    using Clock = ADAPTER_CLOCK;
    using Ms = std::chrono::milliseconds;
    Clock::time_point due = Clock::now();

public:
    // Waits until the next tick is due: in a thread of its own, as in DHD's loops.
    void wait() const {
        while (Clock::now() < due + Ms(1)) {}
    }
    // To be called once per tick, after the reading.
    std::uint32_t late_ticks() {
        const auto now = Clock::now();
        due += Ms(1);
        if (due > now) due = now; // a driver may run a little faster than 1 kHz
        const auto late = (now - due) / Ms(1);
        due += late * Ms(1);
        return static_cast<std::uint32_t>(late);
    }
};

// Prints why the ticks ended; returns the exit code.
static int reported(const char *device, palpate_session session, int code) {
    palpate_report report = {};
    const bool fault = code == PALPATE_CODE_FAULT && !palpate_read_report(session, &report, sizeof report);
    const char *why = fault ? palpate_fault_text(report.fault) : palpate_error_text(code);
    std::printf("%s: %s\n", device, code ? why : "ended");
    palpate_close(session);
    return code != PALPATE_CODE_OK;
}
