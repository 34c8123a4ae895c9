// The models that strings follow, and what is asked of them: this file alone lists them. A model is
// a class over a string's constants with a law in the contact problem and a motion from tick to
// tick. RT: yes; choosing among one costs nothing.
#pragma once

#include <concepts>
#include <variant>

#include "core/instrument/quasi_static_string.h"

namespace hapticd {

/// What a model can be asked; QuasiStaticString says what the answers mean.
template <typename Model>
concept IsStringModel = requires(const Model& model, double x, std::int64_t t_ns,
                                 const StringState& state, const SoundingString& sounding,
                                 const StringTouch& touch, StringEvents& events) {
  { model.yields() } -> std::same_as<bool>;
  { model.bends() } -> std::same_as<bool>;
  { model.law(x, x) } -> std::same_as<Deflection>;
  { model.law_in_series(x, x, x) } -> std::same_as<SeriesDeflection>;
  { model.may_exceed(x, x) } -> std::same_as<bool>;
  { model.reach(state, x, t_ns) } -> std::same_as<double>;
  { model.advance(sounding, touch, events) } -> std::same_as<StringResponse>;
};

template <IsStringModel... Models>
using OneOf = std::variant<Models...>;

/// The models.
using StringModel = OneOf<QuasiStaticString>;

/// The model that a string follows; views the string.
[[nodiscard]] inline StringModel model_of(const StringConstants& string) noexcept {
  return QuasiStaticString(string);
}

/// ask(model) of the model that a string follows.
template <typename Ask>  // NOLINTNEXTLINE(bugprone-exception-escape): the variant has a value
[[nodiscard]] auto ask_model(const StringConstants& string, const Ask& ask) noexcept {
  return std::visit(ask, model_of(string));
}

/// True where a contact moves the string: it has unknowns of the contact problem.
[[nodiscard]] inline bool yields(const StringConstants& string) noexcept {
  return ask_model(string, [](const auto& model) { return model.yields(); });
}

/// True where pressing the string bends it.
[[nodiscard]] inline bool bends(const StringConstants& string) noexcept {
  return ask_model(string, [](const auto& model) { return model.bends(); });
}

/// How far the vibration reaches beyond R at lambda, m; 0 when silent. A tool nearer than this
/// touches the vibrating string.
[[nodiscard]] inline double envelope(const StringConstants& string, const StringState& state,
                                     double lambda, std::int64_t t_ns) noexcept {
  return ask_model(string, [&](const auto& model) { return model.reach(state, lambda, t_ns); });
}

/// One tick. touch.time.dt_ns == 0: nothing changes, the last force is held. Options and constants
/// may change from tick to tick; a string that may no longer ring is still at once.
[[nodiscard]] inline StringResponse respond(const SoundingString& sounding,
                                            const StringTouch& touch,
                                            StringEvents& events) noexcept {
  return ask_model(sounding.string,
                   [&](const auto& model) { return model.advance(sounding, touch, events); });
}

}  // namespace hapticd
