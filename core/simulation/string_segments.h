// A string that several tools hold, or that lies on rests (string_rests.h), as each of them sees
// it. The string is a polyline through the vertices of all tools that hold it, and over its rests.
// A tool bends the part between its neighbours' vertices (or the string's ends), which acts as a
// separate string: it has the tension of the whole,
//   T + E A ext / L  (ext: of the polyline without this tool), E A L' / L, f L / L' sqrt(T' / T),
// so that the energy of all vertices together is that of the whole string, and what one tool does
// is felt by the others through the shape. The other parts are rigid lines to it. Tools are
// rendered one after the other, so that what one does reaches those before it in the next tick.
// Frames: W. SI. RT: yes; nothing where no string is shared, about 1 us per tool and shared string.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "core/math/fixed_vector.h"
#include "core/simulation/tool_renderer.h"

namespace hapticd {

/// Strings that are held at once, at most.
inline constexpr std::size_t kMaxHeldStrings = kMaxTools * kMaxDeflectingStrings;
/// Rests that one string is held on at once, at most. Fewer: a string that winds over a curved
/// board is drawn through it.
inline constexpr std::size_t kMaxHeldRests = 6;
/// Those of all strings near a tool, at most.
inline constexpr std::size_t kMaxNearRests = 256;
/// Parts of strings that are rigid lines to a tool, at most: one per vertex of the others, and per
/// rest.
inline constexpr std::size_t kMaxRigidParts =
    (kMaxTools - 1) * kMaxDeflectingStrings + kMaxNearRests;
/// Overlap of a tool and a shared string that counts as touching, m: what turning a shape from one
/// tool's terms into another's may round, a hundred times over.
inline constexpr double kSharedRounding = 1e-12;

/// Points of a polyline: both ends, a vertex of every tool, and every rest it lies on.
using StringPoints = FixedVector<Vector3, kMaxTools + kMaxHeldRests + 3>;

/// What holds a string, from end A to end B: tools by their number, rests by rest_holder().
struct SharedString {
  std::int32_t string = 0;
  FixedVector<std::int32_t, kMaxTools + kMaxHeldRests> holders;
};

/// Number `rest` of ToolScene::rests among the holders of a string, and back.
[[nodiscard]] constexpr std::int32_t rest_holder(std::size_t rest) noexcept {
  return -1 - static_cast<std::int32_t>(rest);
}
[[nodiscard]] constexpr bool is_rest(std::int32_t holder) noexcept { return holder < 0; }
[[nodiscard]] constexpr std::size_t rest_of(std::int32_t holder) noexcept {
  return static_cast<std::size_t>(-1 - holder);
}
using StringSharing = FixedVector<SharedString, kMaxHeldStrings>;

/// The part of a string that a tool may bend.
struct StringPart {
  std::int32_t string = 0;
  std::int32_t slot = 0;  ///< how many of the other holders are nearer to A
  Capsule part_W;
  double lambda_from = 0.0;  ///< along the string, of the part's ends
  double lambda_to = 1.0;
};

/// What a tool sees instead of the scene's strings while others hold some. The spans are as large
/// as the scene's, and kMaxRigidParts capsules and their groups larger; empty where there is one
/// tool and no rest.
struct StringSegments {
  std::span<Capsule> capsules_W;
  std::span<CapsuleGroup> groups;
  std::span<StringConstants> strings;
  FixedVector<StringPart, kMaxHeldStrings> parts;  ///< of the strings that others hold
  /// Capsule number strings and lines + its index each.
  FixedVector<RigidPart, kMaxRigidParts> rigid;
  /// Pairs with rigid parts that carried force in the last tick, which no later one may start from.
  FixedVector<ActivePair, kMaxQpUnknowns> rigid_active;
};

/// One tool as the view of another is made from it.
struct StringTool {
  ToolScene* scene;
  ToolState* state;
  StringSegments* view;
  ContactSet* scratch;
};

/// Groups of `capsules` capsules.
[[nodiscard]] inline std::size_t group_count(std::size_t capsules) noexcept {
  return (capsules + kCapsulesPerGroup - 1) / kCapsulesPerGroup;
}

/// How a tool holds a string that yields; null: it does not.
[[nodiscard]] HD_REALTIME const TouchedString* hold_of(const ToolState& state,
                                                       std::int32_t string) noexcept;

/// Where a tool's hold takes the string to.
[[nodiscard]] HD_REALTIME Vector3 vertex_of(const StringTool& tool,
                                            const TouchedString& hold) noexcept;

/// Ends, vertices and rests of a string, from A to B, without that of tool `without` (-1: with
/// all).
HD_REALTIME void string_points(std::span<const StringTool> tools, const StringSharing& holders,
                               std::int32_t string, std::int32_t without,
                               StringPoints& points) noexcept;

/// True where a tool or a rest holds the string.
[[nodiscard]] inline bool is_held(const StringSharing& holders, std::int32_t string) noexcept {
  const auto same = [&](const SharedString& held) { return held.string == string; };
  return std::any_of(holders.begin(), holders.end(), same);
}

/// The string as it is bent by all, leg after leg from A to B.
using StringLegs = FixedVector<Capsule, kMaxTools + kMaxHeldRests + 2>;
HD_REALTIME void string_legs(std::span<const StringTool> tools, const StringSharing& holders,
                             std::int32_t string, StringLegs& legs_W) noexcept;

/// Makes the view of tool number `tool`, which is to go to p_WH in this tick, and puts its holds
/// into the terms of it, which moves nothing. Strings it cannot come near in the tick are left as
/// they are in the scene. Returns the scene it is to be rendered in; views it and the tool's view.
[[nodiscard]] HD_REALTIME ToolScene segment_strings(std::span<const StringTool> tools,
                                                    const StringSharing& holders, std::int32_t tool,
                                                    const Vector3& p_WH) noexcept;

/// Takes over which strings the tool holds after it was rendered, and takes pairs with rigid parts
/// out of its state.
HD_REALTIME void update_sharing(std::span<const StringTool> tools, std::int32_t tool,
                                StringSharing& holders) noexcept;

/// The constants of the part between two points of the polyline `points` (without the tool that
/// bends it) as a separate string.
[[nodiscard]] HD_REALTIME StringConstants part_constants(const StringConstants& whole,
                                                         const StringPoints& points,
                                                         std::size_t part) noexcept;

/// Position along the straight string of a point, in [0, 1].
[[nodiscard]] HD_REALTIME double lambda_of(const Capsule& string, const Vector3& p_W) noexcept;

/// The part of `string` in a tool's view; null: all of it.
[[nodiscard]] inline const StringPart* part_of(const StringSegments& view,
                                               std::int32_t string) noexcept {
  for (const StringPart& part : view.parts) {
    if (part.string == string) return &part;
  }
  return nullptr;
}

/// Position along all of `string` of a place on the part of it in a tool's view.
[[nodiscard]] inline double whole_lambda(const StringSegments& view, std::int32_t string,
                                         double lambda) noexcept {
  const StringPart* part = part_of(view, string);
  if (part == nullptr) return lambda;
  return part->lambda_from + lambda * (part->lambda_to - part->lambda_from);
}

/// The opposite: position along the part of `string` in a tool's view of a place on all of it.
[[nodiscard]] inline double part_lambda(const StringSegments& view, std::int32_t string,
                                        double lambda) noexcept {
  const StringPart* part = part_of(view, string);
  if (part == nullptr) return lambda;
  const double length = part->lambda_to - part->lambda_from;
  if (!(length > 0.0)) return 0.5;
  return std::clamp((lambda - part->lambda_from) / length, 0.0, 1.0);
}

}  // namespace hapticd
