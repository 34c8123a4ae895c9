// hapticd-oracle cases and triangle: single equations of the paper from the loop's own code, beside
// what is printed. Not RT.
#include <array>
#include <cmath>
#include <memory>

#include "core/collision/query.h"
#include "core/instrument/deflection.h"
#include "core/tree/sphere_tree.h"
#include "proto/hints/quantity_option.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/json.h"
#include "tests/oracle/pair_search.h"
#include "tests/oracle/printed_string.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

/// The string the paper refers to, 1.1 m long, and a fingertip.
constexpr double kLength = 1.1;
constexpr double kRadius = 0.34e-3;
constexpr double kFinger = 5e-3;
constexpr double kMargin = 0.005;

/// A sphere at `p`, by the loop's query, and by Eq. 1-4.
Json sphere_json(const Capsule& capsule, const Vector3& p) {
  const std::array<Sphere, 1> finger{{{{0.0, 0.0, 0.0}, kFinger}}};
  const SphereTree tree = build_sphere_tree(finger);
  const auto found = std::make_unique<ContactSet>();
  QueryOptions query;
  query.margin = 1.0;
  find_contacts({tree.view(), {{1.0, 0.0, 0.0, 0.0}, p}}, {{&capsule, 1}, {}}, query, *found);
  const Contact& contact = found->contacts[0];
  const AxisOffset line = axis_offset(capsule, p, true);
  const double length = (capsule.p_B - capsule.p_A).norm();
  const double d = line.offset_W.norm();
  const bool near = d <= kFinger + capsule.r;
  const bool beside = line.lambda >= 0.0 && line.lambda <= 1.0;
  const bool margin = line.lambda >= -kMargin && line.lambda <= 1.0 + kMargin;
  return {{"p_m", json_of(p)},
          {"ours",
           {{"lambda", contact.lambda},
            {"distance_m", contact.gap + kFinger + capsule.r},
            {"gap_m", contact.gap},
            {"nhat", json_of(contact.nhat_OG_W)},
            {"hit", contact.gap <= 0.0}}},
          {"printed",
           {{"lambda", line.lambda},
            {"eq2_without_division_m4", d * d * length * length},
            {"d_m", d},
            {"eq1", near},
            {"eq4", near && beside},
            {"eq4_with_margin", near && margin}}}};
}

Json cases_json() {
  const Capsule capsule{{0.0, 0.0, 0.0}, {kLength, 0.0, 0.0}, kRadius};
  const double touch = kFinger + kRadius;
  Json sweep = Json::array();
  for (int k = -40; k <= 40; ++k) {
    sweep.push_back(sphere_json(capsule, {kLength + 2.5e-4 * k, touch - 1e-3, 0.0}));
  }
  return {{"p_a_m", json_of(capsule.p_A)},
          {"p_b_m", json_of(capsule.p_B)},
          {"r_c_m", capsule.r},
          {"r_t_m", kFinger},
          {"margin_of_lambda", kMargin},
          {"beside", sphere_json(capsule, {0.4 * kLength, touch - 1e-3, 0.0})},
          {"beyond_the_end", sphere_json(capsule, {kLength + 3e-3, touch - 2e-3, 0.0})},
          {"across_the_end", sweep}};
}

Json triangle_row(const StringConstants& string, double lambda, double delta) {
  const Deflection ours = deflect(string, lambda, delta);
  const PrintedDeflection printed = printed_deflection(string, lambda, delta);
  return {{"lambda", lambda},
          {"delta_m", delta},
          {"l1_m", printed.L1},
          {"l2_m", printed.L2},
          {"theta_1_rad", printed.theta_1},
          {"theta_2_rad", printed.theta_2},
          {"ours",
           {{"f_i_n", ours.axial_force},
            {"t_plus_f_i_n", string.tension + ours.axial_force},
            {"f_n", ours.force},
            {"lateral_n", ours.lateral_force},
            {"k0_n_per_m", small_deflection_stiffness(string, lambda)}}},
          {"printed", {{"f_i_n", printed.F_i}, {"f_n", printed.force}}}};
}

Json triangle_json(const StringParameters& parameters) {
  const StringConstants string = derive_string(parameters);
  Json rows = Json::array();
  for (const double lambda : {0.5, 0.25, 0.1, 0.0}) {
    for (const double delta : {0.0, 1e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2}) {
      rows.push_back(triangle_row(string, lambda, delta));
    }
  }
  return {{"length_m", string.length},
          {"tension_n", string.tension},
          {"youngs_modulus_pa", parameters.youngs_modulus},
          {"radius_m", parameters.radius},
          {"rows", rows}};
}

struct TriangleOptions {
  StringParameters string;
  double length = kLength;
  std::string output;
};

}  // namespace

void add_cases_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "cases", "a sphere beside a string and beyond its end: ours and Eq. 1-4, as JSON");
  const auto output = std::make_shared<std::string>();
  add_output_option(*command, *output);
  command->callback([output] { write_output(*output, text_of(cases_json()) + "\n"); });
}

void add_triangle_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "triangle", "the force triangle of a deflected string: ours and Eq. 10-12, as JSON");
  const auto options = std::make_shared<TriangleOptions>();
  const auto positive = [&](const char* name, double& value, const char* unit, const char* help) {
    CLI::Option* const option = command->add_option(name, value, help)
                                    ->check(CLI::PositiveNumber.description(""))
                                    ->type_name(unit);
    hints::takes_unit(option, unit);
  };
  positive("--length", options->length, "m", "L (1.1)");
  positive("--tension", options->string.tension, "N", "T (30)");
  positive("--youngs-modulus", options->string.youngs_modulus, "Pa", "E (1.9e11)");
  positive("--radius", options->string.radius, "m", "R (0.00034)");
  add_output_option(*command, options->output);
  command->callback([options] {
    options->string.p_WB = {options->length, 0.0, 0.0};
    if (check_string(options->string)) {
      throw std::invalid_argument(
          "the string is out of range: length up to 1e7 m, tension up to 1e6 N, Young's modulus up "
          "to 1e13 Pa, radius up to 1 m");
    }
    write_output(options->output, text_of(triangle_json(options->string)) + "\n");
  });
}

}  // namespace hapticd
