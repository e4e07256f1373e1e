/// \file  The differences between Embree 3 (Debian 12) and 4 (Ubuntu 24.04).
#pragma once
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace enfilade::mesh::detail::embree {

#if RTC_VERSION_MAJOR >= 4

inline void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &rays, &arguments);
}
inline void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, nullptr); }
inline void occluded(const int* valid, RTCScene scene, RTCRay16& rays) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded16(valid, scene, &rays, &arguments);
}
inline void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }

#else

inline RTCIntersectContext context(RTCIntersectContextFlags flags) {
  RTCIntersectContext made;
  rtcInitIntersectContext(&made);
  made.flags = flags;
  return made;
}
inline void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
  RTCIntersectContext coherent = context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  rtcIntersect16(valid, scene, &coherent, &rays);
}
inline void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext single = context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  rtcIntersect1(scene, &single, &ray);
}
inline void occluded(const int* valid, RTCScene scene, RTCRay16& rays) {
  RTCIntersectContext coherent = context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  rtcOccluded16(valid, scene, &coherent, &rays);
}
inline void occluded(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext single = context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  rtcOccluded1(scene, &single, &ray);
}

#endif

}  // namespace enfilade::mesh::detail::embree
