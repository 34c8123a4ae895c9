// See peer_query.h.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>

#include "tests/benchmark/peers/peer_query.h"

namespace hapticd::test {
namespace {

using Object = fcl::CollisionObjectd;
using Manager = fcl::DynamicAABBTreeCollisionManagerd;

/// What the callback needs to know about an object: a sphere, or a capsule.
struct Primitive {
  std::array<double, 3> p_A, p_B;
  double r;
};

fcl::Vector3d vector(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

std::array<double, 3> array(const fcl::Vector3d& p) { return {p[0], p[1], p[2]}; }

/// Shared by all calls of one query.
struct Count {
  double margin;
  int pairs = 0;
};

/// Exact test of a pair whose boxes overlap, the margin being part of the tool's boxes. FCL hands
/// the objects over in either order.
bool count_pair(Object* first, Object* second, void* data) {
  auto& count = *static_cast<Count*>(data);
  const bool first_is_tool = first->getUserData() == nullptr;
  const Object& tool = first_is_tool ? *first : *second;
  const auto& obstacle =
      *static_cast<const Primitive*>((first_is_tool ? second : first)->getUserData());
  const double r =
      static_cast<const fcl::Sphered*>(tool.collisionGeometry().get())->radius - count.margin;
  const std::array<double, 3> C = array(tool.getTranslation());
  count.pairs +=
      nearer(C, r, nearest_point(obstacle.p_A, obstacle.p_B, C), obstacle.r, count.margin) ? 1 : 0;
  return false;
}

}  // namespace

struct FclQuery::Managers {
  PeerScene scene;
  double margin;
  std::vector<std::unique_ptr<Object>> tool, obstacles;
  std::vector<std::unique_ptr<Primitive>> primitives;
  Manager tool_manager, obstacle_manager;

  void add_obstacle(std::shared_ptr<fcl::CollisionGeometryd> shape, const fcl::Transform3d& X_WO,
                    const Primitive& primitive) {
    primitives.push_back(std::make_unique<Primitive>(primitive));
    obstacles.push_back(std::make_unique<Object>(std::move(shape), X_WO));
    obstacles.back()->setUserData(primitives.back().get());
    obstacle_manager.registerObject(obstacles.back().get());
  }
};

FclQuery::FclQuery(const PeerScene& scene, double margin)
    : managers_(std::make_unique<Managers>()) {
  Managers& m = *managers_;
  m.scene = scene;
  m.margin = margin;
  for (const PeerSphere& sphere : scene.tool_G) {
    m.tool.push_back(std::make_unique<Object>(std::make_shared<fcl::Sphered>(sphere.r + margin)));
    m.tool.back()->setUserData(nullptr);  // marks the tool; FCL leaves it unset
    m.tool_manager.registerObject(m.tool.back().get());
  }
  for (const PeerSphere& sphere : scene.body_W) {
    fcl::Transform3d X_WO = fcl::Transform3d::Identity();
    X_WO.translation() = vector(sphere.p);
    m.add_obstacle(std::make_shared<fcl::Sphered>(sphere.r), X_WO, {sphere.p, sphere.p, sphere.r});
  }
  for (const PeerCapsule& capsule : scene.capsules_W) {
    const fcl::Vector3d axis = vector(capsule.p_B) - vector(capsule.p_A);
    fcl::Transform3d X_WO = fcl::Transform3d::Identity();
    X_WO.linear() =
        fcl::Quaterniond::FromTwoVectors(fcl::Vector3d::UnitZ(), axis).toRotationMatrix();
    X_WO.translation() = 0.5 * (vector(capsule.p_A) + vector(capsule.p_B));
    m.add_obstacle(std::make_shared<fcl::Capsuled>(capsule.r, axis.norm()), X_WO,
                   {capsule.p_A, capsule.p_B, capsule.r});
  }
  m.tool_manager.setup();
  m.obstacle_manager.setup();
}

FclQuery::~FclQuery() = default;

int FclQuery::pairs(const PeerPose& X_WG) {
  Managers& m = *managers_;
  fcl::Matrix3d R;
  R << X_WG.R[0], X_WG.R[1], X_WG.R[2], X_WG.R[3], X_WG.R[4], X_WG.R[5], X_WG.R[6], X_WG.R[7],
      X_WG.R[8];
  for (std::size_t i = 0; i < m.tool.size(); ++i) {
    // A sphere need not be turned.
    m.tool[i]->setTranslation(R * vector(m.scene.tool_G[i].p) + vector(X_WG.p));
    m.tool[i]->computeAABB();
  }
  m.tool_manager.update();
  Count count{m.margin};
  m.tool_manager.collide(&m.obstacle_manager, &count, count_pair);
  return count.pairs;
}

}  // namespace hapticd::test
