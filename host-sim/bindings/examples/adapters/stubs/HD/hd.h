/* OUR STUB of the few declarations of OpenHaptics that touch.cpp needs, written from its public documentation, so
 * that the adapter compiles in the tests. Not the vendor's header: build against theirs. The constants' values differ. */
#ifndef STUB_HD_H
#define STUB_HD_H

typedef unsigned int HHD;
typedef unsigned int HDenum;
typedef double HDdouble;
typedef unsigned char HDboolean;
typedef unsigned long HDSchedulerHandle;
typedef unsigned int HDCallbackCode;
typedef struct { HDenum errorCode; int internalErrorCode; HHD hHD; } HDErrorInfo;
typedef HDCallbackCode (*HDSchedulerCallback)(void *data);

#define HDCALLBACK
#define HD_DEFAULT_DEVICE 0
#define HD_INVALID_HANDLE 0xFFFFFFFFu
enum { HD_CURRENT_POSITION = 1, HD_CURRENT_FORCE, HD_FORCE_OUTPUT, HD_CALLBACK_DONE, HD_CALLBACK_CONTINUE };
#define HD_DEVICE_ERROR(error) ((error).errorCode != 0)
#define HD_MAX_SCHEDULER_PRIORITY 65535

#ifdef __cplusplus
extern "C" {
#endif
HHD hdInitDevice(const char *name);
void hdDisableDevice(HHD device);
void hdEnable(HDenum capability);
void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
void hdGetDoublev(HDenum name, HDdouble *values);
void hdSetDoublev(HDenum name, const HDdouble *values);
HDErrorInfo hdGetError(void);
void hdStartScheduler(void);
void hdStopScheduler(void);
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void *data, unsigned short priority);
void hdUnschedule(HDSchedulerHandle handle);
#ifdef __cplusplus
}
#endif
#endif
