#include "sim_fixtures/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>

#include "core/base/ensure.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Real-Time Collision Detection's regions of a triangle (Ericson 2005, section 5.1.5), in barycentric form.
Vector3d NearestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double scale = 1 / (va + vb + vc);
  return a + vb * scale * ab + vc * scale * ac;
}

struct NearestSearch {
  std::span<const TriangleMesh> meshes;
  Vector3d x_in_world;
  double best_m;
  std::optional<Vector3d> nearest;
};

bool VisitTriangle(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<NearestSearch*>(arguments->userPtr);
  const TriangleMesh& mesh = search.meshes[arguments->geomID];
  const auto& corners = mesh.triangles[arguments->primID];
  const auto corner = [&](int i) -> Vector3d { return mesh.vertices_in_world[corners[i]].cast<double>(); };
  const Vector3d candidate = NearestOnTriangle(search.x_in_world, corner(0), corner(1), corner(2));
  const double distance = (candidate - search.x_in_world).norm();
  if (!(distance < search.best_m)) return false;
  search.best_m = distance;
  search.nearest = candidate;
  arguments->query->radius = static_cast<float>(distance);
  return true;
}

Vector3d AtBarycentric(const std::vector<Vector3f>& values, const std::array<std::uint32_t, 3>& corners, double u,
                       double v) {
  return (1 - u - v) * values[corners[0]].cast<double>() + u * values[corners[1]].cast<double>() +
         v * values[corners[2]].cast<double>();
}

}  // namespace

struct RayScene::Handles {
  std::unique_ptr<RTCDeviceTy, ReleaseDevice> device;
  std::unique_ptr<RTCSceneTy, ReleaseScene> scene;
};

RayScene::RayScene(std::vector<TriangleMesh> meshes) : meshes_(std::move(meshes)), handles_(new Handles) {
  // One thread builds the tree: rays through shared edges then hit the same triangle in every run.
  handles_->device.reset(rtcNewDevice("threads=1,set_affinity=0"));
  Ensure(handles_->device != nullptr, "Embree opens a device");
  handles_->scene.reset(rtcNewScene(handles_->device.get()));
  rtcSetSceneFlags(handles_->scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (const TriangleMesh& mesh : meshes_) {
    RTCGeometry geometry = rtcNewGeometry(handles_->device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vector3f),
                                             mesh.vertices_in_world.size());
    std::copy_n(mesh.vertices_in_world.data(), mesh.vertices_in_world.size(), static_cast<Vector3f*>(vertices));
    void* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            sizeof(mesh.triangles[0]), mesh.triangles.size());
    std::copy_n(mesh.triangles.data(), mesh.triangles.size(), static_cast<std::array<std::uint32_t, 3>*>(corners));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(handles_->scene.get(), geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(handles_->scene.get());
  Ensure(rtcGetDeviceError(handles_->device.get()) == RTC_ERROR_NONE, "Embree builds the scene");
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::Shoot(const Vector3d& origin, int count, RayPacket& packet) const {
  alignas(64) int valid[kRayPacket];
  RTCRayHit16 rays;
  for (int i = 0; i < kRayPacket; ++i) {
    valid[i] = i < count ? -1 : 0;
    rays.ray.org_x[i] = static_cast<float>(origin.x());
    rays.ray.org_y[i] = static_cast<float>(origin.y());
    rays.ray.org_z[i] = static_cast<float>(origin.z());
    rays.ray.dir_x[i] = packet.direction_x[i];
    rays.ray.dir_y[i] = packet.direction_y[i];
    rays.ray.dir_z[i] = packet.direction_z[i];
    rays.ray.tnear[i] = 0;
    rays.ray.tfar[i] = kInfinity;
    rays.ray.time[i] = 0;
    rays.ray.mask[i] = ~0U;
    rays.ray.id[i] = 0;
    rays.ray.flags[i] = 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, handles_->scene.get(), &context, &rays);
  for (int i = 0; i < count; ++i) {
    if (rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
      packet.mesh[i] = kMissed;
      continue;
    }
    const TriangleMesh& mesh = meshes_[rays.hit.geomID[i]];
    const auto& corners = mesh.triangles[rays.hit.primID[i]];
    const float u = rays.hit.u[i], v = rays.hit.v[i];
    const Vector3f normal = (1 - u - v) * mesh.normals_in_world[corners[0]] + u * mesh.normals_in_world[corners[1]] +
                            v * mesh.normals_in_world[corners[2]];
    packet.mesh[i] = static_cast<int>(rays.hit.geomID[i]);
    packet.distance[i] = rays.ray.tfar[i];
    packet.normal_x[i] = normal.x(), packet.normal_y[i] = normal.y(), packet.normal_z[i] = normal.z();
  }
}

std::optional<SurfacePoint> RayScene::FirstHit(const Vector3d& origin, const Vector3d& direction) const {
  RTCRayHit ray{};
  const Vector3f from = origin.cast<float>(), along = direction.normalized().cast<float>();
  ray.ray.org_x = from.x(), ray.ray.org_y = from.y(), ray.ray.org_z = from.z();
  ray.ray.dir_x = along.x(), ray.ray.dir_y = along.y(), ray.ray.dir_z = along.z();
  ray.ray.tfar = kInfinity;
  ray.ray.mask = ~0U;
  ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(handles_->scene.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const TriangleMesh& mesh = meshes_[ray.hit.geomID];
  const auto& corners = mesh.triangles[ray.hit.primID];
  const double u = ray.hit.u, v = ray.hit.v;
  return SurfacePoint{AtBarycentric(mesh.vertices_in_world, corners, u, v),
                      AtBarycentric(mesh.normals_in_world, corners, u, v).normalized(),
                      static_cast<int>(ray.hit.geomID)};
}

bool RayScene::Occluded(const Vector3d& from, const Vector3d& to, double margin_m) const {
  const Vector3d whole = to - from;
  const double length = whole.norm();
  if (length <= 2 * margin_m) return false;
  const Vector3d along = whole / length;
  const Vector3f origin = (from + margin_m * along).cast<float>();
  RTCRay ray{};
  ray.org_x = origin.x(), ray.org_y = origin.y(), ray.org_z = origin.z();
  ray.dir_x = static_cast<float>(along.x());
  ray.dir_y = static_cast<float>(along.y());
  ray.dir_z = static_cast<float>(along.z());
  ray.tfar = static_cast<float>(length - 2 * margin_m);
  ray.mask = ~0U;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(handles_->scene.get(), &context, &ray);
  return ray.tfar < 0;  // Embree's mark of an occluded ray
}

std::optional<Vector3d> RayScene::Nearest(const Vector3d& x_in_world, double reach_m) const {
  NearestSearch search{meshes_, x_in_world, reach_m, std::nullopt};
  RTCPointQuery query{};
  query.x = static_cast<float>(x_in_world.x());
  query.y = static_cast<float>(x_in_world.y());
  query.z = static_cast<float>(x_in_world.z());
  query.radius = static_cast<float>(reach_m);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(handles_->scene.get(), &query, &context, VisitTriangle, &search);
  return search.nearest;
}

}  // namespace rigcal::sim
