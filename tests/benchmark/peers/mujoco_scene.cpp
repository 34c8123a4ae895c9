// See mujoco_scene.h.
#include "tests/benchmark/peers/mujoco_scene.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

constexpr double kTick = 1e-3;
/// Of the simulated tool: light, so that the spring carries it along.
constexpr double kMass = 0.1;      // kg
constexpr double kInertia = 2e-4;  // kg m^2

void write_sphere(std::ostream& xml, const Sphere& sphere) {
  xml << "<geom type='sphere' size='" << sphere.r << "' pos='" << sphere.p.transpose() << "'/>\n";
}

/// A string as a chain of capsules.
void write_chain(std::ostream& xml, const Capsule& string, int links) {
  const Vector3 way = (string.p_B - string.p_A) / links;
  for (int i = 0; i < links; ++i) {
    xml << "<body><geom type='capsule' size='" << string.r << "' fromto='"
        << (string.p_A + i * way).transpose() << ' ' << (string.p_A + (i + 1) * way).transpose()
        << "'/></body>\n";
  }
}

/// Boxes on the chords of every third row of spheres of equal z, cut along x: their tops are the
/// surface of the body to 0.3 mm.
void write_boxes(std::ostream& xml, const std::vector<Sphere>& spheres, int links) {
  constexpr std::size_t kRowsPerBox = 3;
  std::map<double, Sphere> rows;
  double half_length = 0.0;
  for (const Sphere& sphere : spheres) {
    rows.try_emplace(sphere.p.z(), sphere);
    half_length = std::max(half_length, sphere.p.x());
  }
  std::vector<Sphere> corners;
  for (const auto& [z, sphere] : rows) corners.push_back(sphere);
  for (std::size_t k = 0; k + kRowsPerBox < corners.size(); k += kRowsPerBox) {
    const Sphere& from = corners[k];
    const Vector3 chord = corners[k + kRowsPerBox].p - from.p;
    const Vector3 centre = from.p + 0.5 * chord;
    const double half_width = 0.5 * std::hypot(chord.y(), chord.z());
    for (int i = 0; i < links; ++i) {
      const double x = half_length * ((2.0 * i + 1.0) / links - 1.0);
      xml << "<body><geom type='box' size='" << half_length / links << ' ' << from.r << ' '
          << half_width << "' pos='" << x << ' ' << centre.y() << ' ' << centre.z()
          << "' xyaxes='1 0 0 0 " << chord.z() << ' ' << -chord.y() << "'/></body>\n";
    }
  }
}

/// Each obstacle a static body of its own: the broad phase sorts bodies.
void write_obstacles(std::ostream& xml, const TickParts& parts, const MujocoSettings& settings) {
  for (const Capsule& string : parts.capsules_W) write_chain(xml, string, settings.links);
  if (settings.body_as_boxes) {
    write_boxes(xml, parts.body_W, settings.links);
    return;
  }
  for (const Sphere& sphere : parts.body_W) {
    xml << "<body>";
    write_sphere(xml, sphere);
    xml << "</body>\n";
  }
}

void write_tool(std::ostream& xml, const std::vector<Sphere>& spheres) {
  xml << "<body name='tool' childclass='tool'><freejoint/><inertial pos='0 0 0' mass='" << kMass
      << "' diaginertia='" << kInertia << ' ' << kInertia << ' ' << kInertia << "'/>\n";
  for (const Sphere& sphere : spheres) write_sphere(xml, sphere);
  xml << "</body>\n";
}

std::string model_text(const TickParts& parts, const MujocoSettings& settings) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><option timestep='" << kTick / settings.steps_per_tick
      << "' gravity='0 0 0' cone='elliptic' solver='" << settings.solver << "'/>\n"
      << "<size njmax='1000' nconmax='1000' nstack='20000000'/>\n"
      // Nothing but tool and obstacle may touch.
      << "<default><geom contype='0' conaffinity='1' condim='1' solref='" << settings.contact_time
      << " 1'/><default class='tool'><geom contype='1' conaffinity='0'/></default></default>\n"
      << "<worldbody>\n";
  write_obstacles(xml, parts, settings);
  write_tool(xml, parts.tool_G);
  xml << "</worldbody></mujoco>\n";
  return xml.str();
}

mjModel* compile(const std::string& text) {
  constexpr const char* kName = "scene.xml";
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(text.size()));
  std::memcpy(files->filedata[0], text.data(), text.size());
  char error[1000] = "";
  mjModel* model = mj_loadXML(kName, files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (model == nullptr) throw std::runtime_error(error);
  return model;
}

Vector3 vector(const mjtNum* p) { return {p[0], p[1], p[2]}; }

}  // namespace

MujocoScene::MujocoScene(const TickParts& parts, const CouplingStiffness& stiffness,
                         const MujocoSettings& settings)
    : stiffness_(stiffness),
      steps_per_tick_(settings.steps_per_tick),
      model_(compile(model_text(parts, settings))),
      data_(mj_makeData(model_)),
      tool_(mj_name2id(model_, mjOBJ_BODY, "tool")) {}

MujocoScene::~MujocoScene() {
  mj_deleteData(data_);
  mj_deleteModel(model_);
}

void MujocoScene::place(const Pose& X_WG) {
  mj_resetData(model_, data_);
  const mjtNum qpos[] = {X_WG.p.x(), X_WG.p.y(), X_WG.p.z(), X_WG.q.w(),
                         X_WG.q.x(), X_WG.q.y(), X_WG.q.z()};
  std::copy(std::begin(qpos), std::end(qpos), data_->qpos);
  mj_forward(model_, data_);
  X_WH_before_ = X_WG;
}

Pose MujocoScene::X_WG() const {
  const mjtNum* qpos = data_->qpos;
  return {renormalised({qpos[3], qpos[4], qpos[5], qpos[6]}), vector(qpos)};
}

void MujocoScene::pull(const Pose& X_WH, const Twist& V_WH) {
  const Pose X = X_WG();
  const PoseError error_GH = coupling_error(X, X_WH, Vector3::Zero());
  // A free joint's angular velocity is in G.
  const Vector3 v = vector(data_->qvel);
  const Vector3 w = X.q * vector(data_->qvel + 3);
  f_H_W_ = -(stiffness_.kt * error_GH.dp + 2.0 * std::sqrt(stiffness_.kt * kMass) * (V_WH.v - v));
  const Vector3 torque = stiffness_.kr() * error_GH.dtheta +
                         2.0 * std::sqrt(stiffness_.kr() * kInertia) * (V_WH.w - w);
  mjtNum* applied = data_->xfrc_applied + 6 * tool_;
  for (int k = 0; k < 3; ++k) {
    applied[k] = -f_H_W_[k];
    applied[k + 3] = torque[k];
  }
}

void MujocoScene::tick(const Pose& X_WH) {
  const ToolMotion way = motion_between(X_WH_before_, X_WH);
  const Twist V_WH{way.dp / kTick, way.dtheta / kTick};
  for (int step = 1; step <= steps_per_tick_; ++step) {
    const Pose X_now =
        step == steps_per_tick_
            ? X_WH
            : moved(X_WH_before_, scaled(way, static_cast<double>(step) / steps_per_tick_));
    pull(X_now, V_WH);
    mj_step(model_, data_);
  }
  X_WH_before_ = X_WH;
}

}  // namespace hapticd::test
