/* Counts the allocations in ticks: the linker redirects every allocation to this file. Argument: path
 * of a patch file. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palpate.h"

static int counts = 0, allocations = 0;

void *__real_malloc(size_t bytes);
void *__real_calloc(size_t count, size_t bytes);
void *__real_realloc(void *old, size_t bytes);
int __real_posix_memalign(void **place, size_t alignment, size_t bytes);
void *__wrap_malloc(size_t bytes) { return allocations += counts, __real_malloc(bytes); }
void *__wrap_calloc(size_t count, size_t bytes) { return allocations += counts, __real_calloc(count, bytes); }
void *__wrap_realloc(void *old, size_t bytes) { return allocations += counts, __real_realloc(old, bytes); }
int __wrap_posix_memalign(void **place, size_t alignment, size_t bytes) {
    return allocations += counts, __real_posix_memalign(place, alignment, bytes);
}

int main(int argc, char **argv) {
    palpate_session s;
    palpate_info info;
    palpate_report report;
    palpate_contact contact;
    double force_n[3], most_n = 0.0;
    counts = 1;
    if (argc < 2 || palpate_open_patch(argv[1], NULL, &s) || palpate_read_info(s, &info, sizeof info)) return 2;
    const int opening = allocations;
    allocations = 0;
    if (palpate_arm(s)) return 2;
    for (int tick = 0; tick < 1500; tick++) {
        double tip_m[3];
        memcpy(tip_m, info.site_m, sizeof tip_m);
        tip_m[2] += tick < 800 ? 1e-3 : 1e-3 - 1e-5 * (tick - 800);
        if (palpate_tick(s, tip_m, force_n) || palpate_read_report(s, &report, sizeof report)) return 2;
        if (palpate_read_contact(s, &contact, sizeof contact)) return 2;
        if (tick == 1200 && palpate_set_modulus(s, 0.8 * info.youngs_modulus_pa)) return 2;
        most_n = force_n[2] > most_n ? force_n[2] : most_n;
    }
    /* neither failures, their messages nor a reset may allocate */
    if (palpate_tick(s, NULL, force_n) != PALPATE_CODE_NULL || palpate_tick(0, force_n, force_n) != PALPATE_CODE_NO_SESSION) return 2;
    if (palpate_tick(s, info.site_m, force_n) != PALPATE_CODE_FAULT || palpate_reset(s)) return 2;
    counts = 0;
    printf("%d allocations when opened, %d afterwards, %s\n", opening, allocations, most_n > 0.01 ? "pressed" : "not pressed");
    return palpate_close(s);
}
