/** Linkage of the public functions; symbols are hidden unless marked HL_API. */
#ifndef HALFLIGHT_API_H
#define HALFLIGHT_API_H

#if defined(_WIN32) || !defined(__GNUC__)
#define HL_API
#else
#define HL_API __attribute__((visibility("default")))
#endif

#if defined(__GNUC__)
#define HL_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define HL_PRINTF(text, first)
#endif

#endif
