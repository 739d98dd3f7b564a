/* OUR STUB of the few declarations of Force Dimension's DHD that omega.cpp needs, written from its public
 * documentation, so that the adapter compiles in the tests. Not the vendor's header: build against theirs. */
#ifndef STUB_DHDC_H
#define STUB_DHDC_H

#define DHD_ON 1
#define DHD_OFF 0
#define DHD_TIMEGUARD 1

#ifdef __cplusplus
extern "C" {
#endif
int dhdOpen(void);
int dhdClose(char id);
int dhdEnableForce(unsigned char on, char id);
int dhdGetPosition(double *x_m, double *y_m, double *z_m, char id);
int dhdSetForce(double x_n, double y_n, double z_n, char id);
const char *dhdErrorGetLastStr(void);
double dhdGetTime(void);
#ifdef __cplusplus
}
#endif
#endif
