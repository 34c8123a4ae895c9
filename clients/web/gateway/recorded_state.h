// States made of a recording. Its ticks hold what went in and came out, poses and wrenches; strings
// and contacts stand in its events alone. So a string's radius here is the law its StringRadius
// gives, and a contact is the one its Contact began with, carried along by the tool (by its
// translation; turning is left out) until it ends. The full States are those of hapticd replaying
// it. Pure. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <tuple>

#include "hapticd/v1/recording.pb.h"

namespace hapticd::web {

/// Envelope below which a string is drawn at rest, m: a hundredth of what a screen resolves.
inline constexpr double kStillEnvelope_m = 1e-6;

class RecordedState {
 public:
  /// Another scene begins: nothing is touched, nothing sounds.
  void take_scene(const v1::SceneRecord& record);
  /// `item`, while the tools were as in `tick`, the newest before it; null: not known.
  void take_event(const v1::Item& item, const v1::TickRecord* tick);
  /// Forgets all events.
  void clear();

  /// The State of a tick, after all events before it.
  [[nodiscard]] v1::State state_of(const v1::TickRecord& tick) const;

 private:
  using Point = std::array<double, 3>;
  /// Tool, part, kind of object (BodyCase of Contact), its index.
  using Touch = std::tuple<std::uint32_t, std::uint32_t, int, std::uint32_t>;
  struct Touched {
    v1::Contact contact;
    Point p_WG{};  ///< of the tool at its beginning
    bool placed = false;
  };
  struct Course {
    v1::StringRadius radius;
    float lambda = 0.0F;
  };

  void take_contact(const v1::Contact& contact, const v1::TickRecord* tick);
  void add_strings(const v1::TickRecord& tick, v1::State& state) const;
  void add_contacts(const v1::TickRecord& tick, v1::State& state) const;

  v1::Scene scene_;
  std::map<std::uint32_t, Course> strings_;  ///< by index; those that an event spoke of
  std::map<Touch, Touched> touched_;
};

/// What clients are told of a scene when it is loaded, as far as a recording has it.
[[nodiscard]] v1::SceneInfo scene_info_of(const v1::SceneRecord& record,
                                          const v1::RecordHeader& header);

}  // namespace hapticd::web
