// See model_catalogue.h.
#include "server/model/shapes/model_catalogue.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "server/model/shapes/guqin_model.h"
#include "server/model/shapes/hand_model.h"
#include "server/model/shapes/primitive_mesh.h"

namespace hapticd {
namespace {

template <typename T, const auto& Fields>
std::vector<ModelParameter> list_parameters() {
  const T defaults;
  std::vector<ModelParameter> parameters;
  for (const ParameterField<T>& field : Fields) {
    parameters.push_back({field.range, defaults.*field.member});
  }
  return parameters;
}

template <const auto& Fields>
[[noreturn]] void throw_unknown(const std::string& name) {
  std::string text = "no parameter named " + name + "; there are";
  for (const auto& field : Fields) text.append(" ").append(field.range.name);
  throw std::invalid_argument(text);
}

/// Calls Make with the defaults of T, `values` set over them.
template <typename T, const auto& Fields, TriangleMesh (*Make)(const T&)>
TriangleMesh make_with(std::span<const ParameterValue> values) {
  T parameters;
  for (const ParameterValue& value : values) {
    const auto field = std::find_if(Fields.begin(), Fields.end(), [&](const auto& candidate) {
      return candidate.range.name == value.first;
    });
    if (field == Fields.end()) throw_unknown<Fields>(value.first);
    parameters.*field->member = value.second;
  }
  return Make(parameters);
}

template <typename T, const auto& Fields, TriangleMesh (*Make)(const T&)>
constexpr NamedModel named(std::string_view name, std::string_view description, int solids) {
  return {name, description, solids, &list_parameters<T, Fields>, &make_with<T, Fields, Make>};
}

template <TriangleMesh (*Make)(const GuqinParameters&)>
constexpr NamedModel guqin(std::string_view name, std::string_view description, int solids) {
  return named<GuqinParameters, kGuqinFields, Make>(name, description, solids);
}

template <Finger Which>
TriangleMesh make_tip(const HandParameters& parameters) {
  return make_finger_tip(parameters, Which);
}

template <Finger Which>
TriangleMesh make_nail(const HandParameters& parameters) {
  return make_finger_nail(parameters, Which);
}

template <TriangleMesh (*Make)(const HandParameters&)>
constexpr NamedModel hand(std::string_view name, std::string_view description) {
  return named<HandParameters, kHandFields, Make>(name, description, 1);
}

constexpr std::array kCatalogue{
    guqin<make_guqin_body>("guqin_body", "body of a Guqin", 1),
    guqin<make_guqin_bridge>("guqin_bridge", "its bridge (yueshan)", 1),
    guqin<make_guqin_gum>("guqin_gum", "its dragon's gum (longyin)", 1),
    guqin<make_guqin_pegs>("guqin_pegs", "its tuning pegs (zhen)", kGuqinStrings),
    guqin<make_guqin_feet>("guqin_feet", "its feet (yanzu)", 2),
    guqin<make_guqin_hui>("guqin_hui", "its markers (hui)", kGuqinMarkers),
    hand<make_hand>("hand", "palm and fingers of a hand that plucks, without pads and nails"),
    hand<make_tip<Finger::kThumb>>("thumb_tip", "pad of the thumb"),
    hand<make_nail<Finger::kThumb>>("thumb_nail", "nail of the thumb"),
    hand<make_tip<Finger::kIndex>>("index_tip", "pad of the index finger"),
    hand<make_nail<Finger::kIndex>>("index_nail", "nail of the index finger"),
    hand<make_tip<Finger::kMiddle>>("middle_tip", "pad of the middle finger"),
    hand<make_nail<Finger::kMiddle>>("middle_nail", "nail of the middle finger"),
    hand<make_tip<Finger::kRing>>("ring_tip", "pad of the ring finger"),
    hand<make_nail<Finger::kRing>>("ring_nail", "nail of the ring finger"),
    hand<make_tip<Finger::kLittle>>("little_tip", "pad of the little finger"),
    hand<make_nail<Finger::kLittle>>("little_nail", "nail of the little finger"),
    named<PillarParameters, kPillarFields, make_pillar>("pillar", "cylinder with rounded rims", 1),
    named<PlateParameters, kPlateFields, make_plate>("plate", "box with rounded edges", 1),
    named<BarParameters, kBarFields, make_bar>("bar", "bar with round ends along x", 1),
    named<EllipsoidParameters, kEllipsoidFields, make_ellipsoid>("ellipsoid", "ellipsoid or sphere",
                                                                 1),
    named<BracketParameters, kBracketFields, make_bracket>("bracket",
                                                           "L or U profile with rounded edges", 1),
};

}  // namespace

std::span<const NamedModel> model_catalogue() { return kCatalogue; }

const NamedModel* find_model(std::string_view name) {
  const auto* const found =
      std::find_if(kCatalogue.begin(), kCatalogue.end(),
                   [&](const NamedModel& model) { return model.name == name; });
  return found == kCatalogue.end() ? nullptr : &*found;
}

}  // namespace hapticd
