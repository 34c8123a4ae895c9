// hapticd-model make and list: the models that come with hapticd.
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "server/model/commands.h"
#include "server/model/printed_json.h"
#include "server/model/shapes/model_catalogue.h"
#include "server/model/source_option.h"

namespace hapticd {
namespace {

struct MakeOptions {
  std::string model;
  std::string mesh;
  std::vector<std::string> set;
};

struct ListOptions {
  bool parameters = false;
  bool json = false;
};

std::string text(std::string_view view) { return std::string(view); }

void list(bool with_parameters) {
  for (const NamedModel& model : model_catalogue()) {
    std::printf("%-16s %s\n", text(model.name).c_str(), text(model.description).c_str());
    if (!with_parameters) continue;
    for (const ModelParameter& parameter : model.parameters()) {
      const ModelRange& range = parameter.range;
      std::printf("  %-24s %-9.4g %s, %g to %g: %s\n", text(range.name).c_str(), parameter.value,
                  text(range.unit).c_str(), range.low, range.high, text(range.meaning).c_str());
    }
  }
}

/// With their parameters.
void list_json() {
  Json models = Json::array();
  for (const NamedModel& model : model_catalogue()) {
    Json parameters = Json::array();
    for (const ModelParameter& parameter : model.parameters()) {
      const ModelRange& range = parameter.range;
      parameters.push_back({{"name", range.name},
                            {"unit", range.unit},
                            {"default", parameter.value},
                            {"least", range.low},
                            {"most", range.high},
                            {"meaning", range.meaning}});
    }
    models.push_back({{"name", model.name},
                      {"description", model.description},
                      {"parameters", std::move(parameters)}});
  }
  print_json({{"models", std::move(models)}});
}

}  // namespace

void add_make_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("make", "write the mesh of a model");
  const auto options = std::make_shared<MakeOptions>();
  command->add_option("MODEL", options->model, "name of the model; hapticd-model list")->required();
  command->add_option("-o,--output", options->mesh, "mesh file to write (.ply or .obj)")
      ->required();
  command->add_option("--set", options->set, "parameter, as in radius=5mm; may be repeated")
      ->type_name("NAME=VALUE");
  command->callback(
      [options] { write_mesh(options->mesh, make_model(options->model, options->set)); });
}

void add_list_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("list", "name the models");
  const auto options = std::make_shared<ListOptions>();
  command->add_flag("--parameters", options->parameters,
                    "with their parameters, defaults and ranges");
  command->add_flag("--json", options->json,
                    "all of it, with the parameters, as one JSON object, for programs");
  command->callback([options] { options->json ? list_json() : list(options->parameters); });
}

}  // namespace hapticd
