/* Checks the return code of every wrong call that a program can make, then the behaviour of a session
 * after errors and faults. Argument: path of a patch file. Prints a line for every unexpected result. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palpate.h"

static int wrong = 0;

#define IS(call, wanted)                                                                               \
    do {                                                                                               \
        palpate_code got = (call);                                                                     \
        if (got != (wanted) || (got && (!strlen(palpate_last_message()) || strchr(palpate_last_message(), '\n')))) { \
            printf("line %d: %s is %d (%s), not %d\n", __LINE__, #call, got, palpate_last_message(), wanted);        \
            wrong++;                                                                                   \
        }                                                                                              \
    } while (0)
#define HOLDS(fact)                                           \
    do {                                                      \
        if (!(fact)) {                                        \
            printf("line %d: %s does not hold\n", __LINE__, #fact); \
            wrong++;                                          \
        }                                                     \
    } while (0)

/* Runs `count` ticks with the tip at a height above the site. */
static palpate_code ticks(palpate_session s, int count, double height_m, double force_n[3]) {
    palpate_info info;
    palpate_code code = palpate_read_info(s, &info, sizeof info);
    for (int n = 0; n < count && !code; n++) {
        double tip_m[3];
        for (int k = 0; k < 3; k++) tip_m[k] = info.site_m[k] + info.axis[k] * height_m;
        code = palpate_tick(s, tip_m, force_n);
    }
    return code;
}

static palpate_report report_of(palpate_session s) {
    palpate_report report;
    memset(&report, 0, sizeof report);
    IS(palpate_read_report(s, &report, sizeof report), PALPATE_CODE_OK);
    return report;
}

static void no_session(palpate_session s) {
    double three[3] = {1.0, 1.0, 1.0};
    palpate_report report;
    palpate_info info;
    uint64_t hash;
    IS(palpate_tick(s, three, three), PALPATE_CODE_NO_SESSION);
    HOLDS(three[0] == 0.0 && three[1] == 0.0 && three[2] == 0.0);
    IS(palpate_read_report(s, &report, sizeof report), PALPATE_CODE_NO_SESSION);
    palpate_contact contact;
    IS(palpate_read_contact(s, &contact, sizeof contact), PALPATE_CODE_NO_SESSION);
    IS(palpate_read_info(s, &info, sizeof info), PALPATE_CODE_NO_SESSION);
    IS(palpate_read_nodes(s, three, 3), PALPATE_CODE_NO_SESSION);
    IS(palpate_read_triangles(s, NULL, 3), PALPATE_CODE_NO_SESSION);
    IS(palpate_state_hash(s, &hash), PALPATE_CODE_NO_SESSION);
    IS(palpate_arm(s), PALPATE_CODE_NO_SESSION);
    IS(palpate_stop(s), PALPATE_CODE_NO_SESSION);
    IS(palpate_clear(s), PALPATE_CODE_NO_SESSION);
    IS(palpate_reset(s), PALPATE_CODE_NO_SESSION);
    IS(palpate_set_modulus(s, 3500.0), PALPATE_CODE_NO_SESSION);
    IS(palpate_lower_force(s, 1.0), PALPATE_CODE_NO_SESSION);
    double upright[4] = {0.0, 0.0, 0.0, 1.0};
    IS(palpate_turn(s, upright), PALPATE_CODE_NO_SESSION);
    IS(palpate_close(s), PALPATE_CODE_NO_SESSION);
    int32_t stage;
    char words[8];
    three[0] = 1.0;
    IS(palpate_commission(s, three, 0.05, 0, three, &stage), PALPATE_CODE_NO_SESSION);
    HOLDS(three[0] == 0.0 && stage == PALPATE_STAGE_STOPPED);
    IS(palpate_commission_text(s, 0.05, words, sizeof words), PALPATE_CODE_NO_SESSION);
    IS(palpate_read_cautions(s, words, sizeof words), PALPATE_CODE_NO_SESSION);
    IS(palpate_write_profile(s, "never.toml"), PALPATE_CODE_NO_SESSION);
}

/* The profile was not commissioned: the session says so, and a commissioning asks its user, step by step. */
static void commissioning(palpate_session s) {
    double reading[3] = {0.0, 0.0, 0.0}, force_n[3] = {9.0, 9.0, 9.0};
    char words[400];
    int32_t stage = 9;
    palpate_info info;
    IS(palpate_read_info(s, &info, sizeof info), PALPATE_CODE_OK);
    HOLDS(info.max_force_n == 0.5);
    IS(palpate_read_cautions(s, words, sizeof words), PALPATE_CODE_OK);
    HOLDS(strstr(words, "not commissioned") != NULL);
    IS(palpate_read_cautions(s, words, 8), PALPATE_CODE_WRONG_SIZE);
    IS(palpate_read_cautions(s, NULL, sizeof words), PALPATE_CODE_NULL);
    IS(palpate_commission(s, reading, 9.0, 0, force_n, &stage), PALPATE_CODE_WRONG_ORDER);
    HOLDS(stage == PALPATE_STAGE_STOPPED && force_n[0] == 0.0);
    IS(palpate_commission(s, NULL, 0.05, 0, force_n, &stage), PALPATE_CODE_NULL);
    IS(palpate_commission(s, reading, 0.05, 0, NULL, &stage), PALPATE_CODE_NULL);
    IS(palpate_commission(s, reading, 0.05, 0, force_n, &stage), PALPATE_CODE_OK);
    HOLDS(stage == PALPATE_STAGE_START);
    IS(palpate_commission_text(s, -1.0, words, sizeof words), PALPATE_CODE_WRONG_ORDER);
    IS(palpate_commission_text(s, 0.05, words, sizeof words), PALPATE_CODE_OK);
    HOLDS(strstr(words, "50 mm along x") != NULL);
    IS(palpate_commission(s, reading, 0.05, 1, force_n, &stage), PALPATE_CODE_OK);
    HOLDS(stage == PALPATE_STAGE_MOVE);
    /* confirmed without a motion */
    IS(palpate_commission(s, reading, 0.05, 1, force_n, &stage), PALPATE_CODE_NOT_COMMISSIONED);
    HOLDS(stage == PALPATE_STAGE_STOPPED && strstr(palpate_last_message(), "along x") != NULL);
    IS(palpate_write_profile(s, "never.toml"), PALPATE_CODE_WRONG_ORDER);
    IS(palpate_write_profile(s, NULL), PALPATE_CODE_NULL);
}

static void opening(const char *patch) {
    palpate_session s = 7;
    const unsigned char junk[64] = {1, 2, 3};
    IS(palpate_open_scene(NULL, NULL, NULL, &s), PALPATE_CODE_NULL);
    HOLDS(s == 0);
    IS(palpate_open_scene("block", NULL, NULL, NULL), PALPATE_CODE_NULL);
    IS(palpate_open_scene("blok", NULL, NULL, &s), PALPATE_CODE_BAD_SCENE);
    HOLDS(strstr(palpate_last_message(), "did you mean") != NULL);
    IS(palpate_open_scene("\xff\xfe", NULL, NULL, &s), PALPATE_CODE_NOT_TEXT);
    IS(palpate_open_scene("nowhere/scene.toml", NULL, NULL, &s), PALPATE_CODE_CANNOT_READ);
    IS(palpate_open_scene("block", "nowhere.patch", NULL, &s), PALPATE_CODE_CANNOT_READ);
    IS(palpate_open_patch(patch, "no device", &s), PALPATE_CODE_BAD_SCENE);
    IS(palpate_open_patch(NULL, NULL, &s), PALPATE_CODE_NULL);
    IS(palpate_open_patch("nowhere.patch", NULL, &s), PALPATE_CODE_CANNOT_READ);
    IS(palpate_open_patch_bytes(junk, sizeof junk, NULL, &s), PALPATE_CODE_BAD_PATCH);
    IS(palpate_open_patch_bytes(junk, 0, NULL, &s), PALPATE_CODE_BAD_PATCH);
    IS(palpate_open_patch_bytes(NULL, 64, NULL, &s), PALPATE_CODE_NULL);
    IS(palpate_open_patch_bytes(junk, (size_t)-1, NULL, &s), PALPATE_CODE_WRONG_SIZE);
    HOLDS(s == 0);
}

static void in_a_session(palpate_session s) {
    double force_n[3] = {9.0, 9.0, 9.0}, few_m[3];
    palpate_report report;
    palpate_info info;
    palpate_input input;
    uint64_t hash, later;
    memset(&input, 0, sizeof input);

    IS(palpate_read_report(s, &report, sizeof report), PALPATE_CODE_WRONG_ORDER);
    IS(palpate_clear(s), PALPATE_CODE_WRONG_ORDER);
    IS(palpate_read_report(s, NULL, sizeof report), PALPATE_CODE_WRONG_ORDER);
    IS(palpate_read_report(s, &report, sizeof report - 1), PALPATE_CODE_WRONG_SIZE);
    IS(palpate_read_info(s, NULL, sizeof info), PALPATE_CODE_NULL);
    IS(palpate_read_info(s, &info, 0), PALPATE_CODE_WRONG_SIZE);
    palpate_contact contact;
    IS(palpate_read_contact(s, NULL, sizeof contact), PALPATE_CODE_NULL);
    IS(palpate_read_contact(s, &contact, sizeof contact - 1), PALPATE_CODE_WRONG_SIZE);
    contact.area_m2 = 9.0;
    IS(palpate_read_contact(s, &contact, sizeof contact), PALPATE_CODE_OK);
    HOLDS(contact.area_m2 == 0.0 && contact.normal_n[2] == 0.0);
    IS(palpate_state_hash(s, NULL), PALPATE_CODE_NULL);
    IS(palpate_read_info(s, &info, sizeof info), PALPATE_CODE_OK);
    IS(palpate_read_nodes(s, few_m, 3), PALPATE_CODE_WRONG_SIZE);
    IS(palpate_read_nodes(s, NULL, 3 * (size_t)info.nodes), PALPATE_CODE_NULL);
    double *nodes_m = malloc(3 * (size_t)info.nodes * sizeof *nodes_m);
    IS(palpate_read_nodes(s, nodes_m, 3 * (size_t)info.nodes), PALPATE_CODE_OK);
    HOLDS(nodes_m[0] != 0.0 || nodes_m[1] != 0.0);
    const size_t three_each = 3 * (size_t)info.triangles;
    uint32_t *corners = malloc(three_each * sizeof *corners);
    IS(palpate_read_triangles(s, corners, three_each - 1), PALPATE_CODE_WRONG_SIZE);
    IS(palpate_read_triangles(s, NULL, three_each), PALPATE_CODE_NULL);
    IS(palpate_read_triangles(s, corners, three_each), PALPATE_CODE_OK);
    double volume_m3 = 0.0; /* of the block 80 x 80 x 40 mm, whose closed surface faces out */
    for (size_t k = 0; k < three_each; k += 3) {
        HOLDS(corners[k] < info.nodes && corners[k + 1] < info.nodes && corners[k + 2] < info.nodes);
        const double *p[3] = {nodes_m + 3 * corners[k], nodes_m + 3 * corners[k + 1], nodes_m + 3 * corners[k + 2]};
        for (int a = 0, b = 1, c = 2; a < 3; a++, b = (b + 1) % 3, c = (c + 1) % 3)
            volume_m3 += p[0][a] * (p[1][b] * p[2][c] - p[1][c] * p[2][b]) / 6.0;
    }
    HOLDS(volume_m3 > 2.5e-4 && volume_m3 < 2.6e-4);
    free(corners);
    free(nodes_m);
    IS(palpate_set_modulus(s, NAN), PALPATE_CODE_OUT_OF_RANGE);
    IS(palpate_set_modulus(s, 10.0 * info.youngs_modulus_pa), PALPATE_CODE_OUT_OF_RANGE);
    IS(palpate_lower_force(s, info.max_force_n * 1.01), PALPATE_CODE_OUT_OF_RANGE);
    IS(palpate_lower_force(s, -1.0), PALPATE_CODE_OUT_OF_RANGE);
    double turn[4] = {0.0, 0.0, 0.0, 2.0};
    IS(palpate_turn(s, NULL), PALPATE_CODE_NULL);
    IS(palpate_turn(s, turn), PALPATE_CODE_OUT_OF_RANGE);
    HOLDS(strstr(palpate_last_message(), "quaternion") != NULL);
    turn[3] = 1.0;
    IS(palpate_turn(s, turn), PALPATE_CODE_OK);

    /* no force before the session is armed */
    IS(ticks(s, 900, 2e-3, force_n), PALPATE_CODE_OK);
    IS(ticks(s, 1, 1e-3, force_n), PALPATE_CODE_OK);
    HOLDS(force_n[0] == 0.0 && force_n[1] == 0.0 && force_n[2] == 0.0);
    HOLDS(report_of(s).mode == PALPATE_MODE_IDLE);

    /* armed: outside the tissue, in contact, and stopped */
    IS(palpate_arm(s), PALPATE_CODE_OK);
    IS(ticks(s, 800, 1e-3, force_n), PALPATE_CODE_OK);
    HOLDS(report_of(s).mode == PALPATE_MODE_ACTIVE);
    IS(palpate_state_hash(s, &hash), PALPATE_CODE_OK);
    for (int n = 0; n < 300; n++) IS(ticks(s, 1, 1e-3 - 1e-5 * n, force_n), PALPATE_CODE_OK);
    report = report_of(s);
    HOLDS(report.contact == 1 && report.force_n[2] == force_n[2] && force_n[2] > 0.005 && report.depth_m > 1.5e-3);
    IS(palpate_state_hash(s, &later), PALPATE_CODE_OK);
    HOLDS(hash != later);
    /* the contact of a round tip: its frictionless force passes through the middle of the ball */
    IS(palpate_read_contact(s, &contact, sizeof contact), PALPATE_CODE_OK);
    HOLDS(fabs(contact.normal_n[2] / report.tissue_n[2] - 1.0) < 0.1 && contact.friction_n[2] == 0.0);
    HOLDS(fabs(contact.torque_nm[1] - contact.normal_n[0] * info.probe_radius_m) < 1e-6 * contact.normal_n[2]);
    HOLDS(contact.area_m2 > 1e-5 && contact.peak_pressure_pa > 100.0 && contact.triangles > 0);
    HOLDS(contact.half_lengths_m[0] >= contact.half_lengths_m[1] && fabs(contact.axes[1][2]) < 0.2);
    IS(palpate_state_hash(s, &hash), PALPATE_CODE_OK);
    HOLDS(hash == later);
    IS(palpate_set_modulus(s, 1.5 * info.youngs_modulus_pa), PALPATE_CODE_OK);
    IS(ticks(s, 1, -2e-3, force_n), PALPATE_CODE_OK);
    HOLDS(report_of(s).waiting_modulus_pa > 0.0 && report_of(s).youngs_modulus_pa == info.youngs_modulus_pa);
    IS(palpate_set_modulus(s, 0.75 * info.youngs_modulus_pa), PALPATE_CODE_OK);
    IS(ticks(s, 1, -2e-3, force_n), PALPATE_CODE_OK);
    HOLDS(report_of(s).waiting_modulus_pa == 0.0 && report_of(s).youngs_modulus_pa < info.youngs_modulus_pa);
    IS(palpate_stop(s), PALPATE_CODE_OK);
    IS(ticks(s, 150, -2e-3, force_n), PALPATE_CODE_OK);
    HOLDS(force_n[2] == 0.0 && report_of(s).mode == PALPATE_MODE_IDLE);
    /* who drives a motor with the torque must not drive it on */
    IS(palpate_read_contact(s, &contact, sizeof contact), PALPATE_CODE_OK);
    HOLDS(contact.normal_n[2] == 0.0 && contact.area_m2 == 0.0 && contact.triangles == 0);

    /* a NULL position counts as a sensor failure: the fault stays until it is cleared */
    force_n[2] = 9.0;
    IS(palpate_tick(s, NULL, force_n), PALPATE_CODE_NULL);
    HOLDS(force_n[2] == 0.0 && report_of(s).fault == 5 && strcmp(palpate_fault_text(5), "no fault") != 0);
    IS(palpate_arm(s), PALPATE_CODE_WRONG_ORDER);
    IS(ticks(s, 1, 2e-3, force_n), PALPATE_CODE_FAULT);
    IS(palpate_clear(s), PALPATE_CODE_OK);
    IS(ticks(s, 1, 2e-3, force_n), PALPATE_CODE_FAULT);
    HOLDS(report_of(s).refused == 1);
    for (int n = 0; n < 120; n++) IS(ticks(s, 1, 2e-3, force_n), PALPATE_CODE_FAULT);
    IS(palpate_clear(s), PALPATE_CODE_OK);
    IS(ticks(s, 3, 2e-3, force_n), PALPATE_CODE_OK);
    HOLDS(report_of(s).mode == PALPATE_MODE_IDLE && report_of(s).fault == 0);

    /* a NULL force, a NULL input and an input of another size count as sensor failures too; NaN and a
     * position outside the workspace are faults of their own */
    for (int kind = 0; kind < 6; kind++) {
        const double nowhere_m[3] = {kind == 4 ? NAN : 5.0, 0.0, 0.0};
        IS(palpate_reset(s), PALPATE_CODE_OK);
        IS(ticks(s, 3, 2e-3, force_n), PALPATE_CODE_OK);
        force_n[0] = 9.0;
        switch (kind) {
        case 0: IS(palpate_tick(s, info.site_m, NULL), PALPATE_CODE_NULL); break;
        case 1: IS(palpate_tick_with(s, NULL, sizeof input, force_n), PALPATE_CODE_NULL); break;
        case 2: IS(palpate_tick_with(s, &input, sizeof input + 8, force_n), PALPATE_CODE_WRONG_SIZE); break;
        case 3: input.sensor_failed = 1; IS(palpate_tick_with(s, &input, sizeof input, force_n), PALPATE_CODE_FAULT); break;
        case 4: IS(palpate_tick(s, nowhere_m, force_n), PALPATE_CODE_FAULT); break;
        default: /* a single jump is a glitch */
            IS(palpate_tick(s, nowhere_m, force_n), PALPATE_CODE_OK);
            IS(palpate_tick(s, nowhere_m, force_n), PALPATE_CODE_FAULT);
            break;
        }
        HOLDS(kind == 0 || force_n[0] == 0.0);
        HOLDS(report_of(s).fault == (kind < 4 ? 5 : kind == 4 ? 1 : 7));
    }

    /* lowered limits stay lowered after a reset */
    IS(palpate_lower_force(s, 0.4), PALPATE_CODE_OK);
    IS(palpate_reset(s), PALPATE_CODE_OK);
    IS(palpate_lower_force(s, 0.45), PALPATE_CODE_OUT_OF_RANGE);
    IS(palpate_read_info(s, &info, sizeof info), PALPATE_CODE_OK);
    HOLDS(fabs(info.max_force_n - 0.4) < 1e-6);
}

int main(int argc, char **argv) {
    palpate_session s = 0;
    if (argc < 2) return 2;
    HOLDS(palpate_last_message()[0] == 0);
    opening(argv[1]);
    no_session(0);
    no_session((palpate_session)-1);
    IS(palpate_open_patch(argv[1], NULL, &s), PALPATE_CODE_OK);
    no_session(s + 1);
    commissioning(s);
    in_a_session(s);
    IS(palpate_close(s), PALPATE_CODE_OK);
    no_session(s);
    for (int code = -2; code < 40; code++) {
        HOLDS(strlen(palpate_error_text(code)) && strlen(palpate_mode_text(code)) && strlen(palpate_fault_text(code)));
    }
    printf("%d wrong\n", wrong);
    return wrong != 0;
}
