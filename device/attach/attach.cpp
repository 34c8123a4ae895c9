// See attach.h.
#include "device/attach/attach.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

void require(const DeviceSheet& sheet, const AttachOptions& options) {
  const std::string fault = options.fault ? options.fault(sheet) : "";
  if (!fault.empty()) {
    throw std::runtime_error("what the device states of itself is not a valid profile: " + fault);
  }
}

/// By a number that a profile of this driver names: whose model is newer than hapticd.
bool names_it(const DeviceSheet& sheet, const DriverEntry& driver, const HidrawNode& node) {
  return sheet.profile.driver == driver.driver &&
         std::any_of(sheet.matches.begin(), sheet.matches.end(), [&](const DeviceMatch& match) {
           return match.vendor_id == node.vendor_id && match.product_id == node.product_id &&
                  match.serial.value_or(node.serial) == node.serial && !match.usage;
         });
}

/// What the driver can drive. A device that pushes must say by its descriptor how; of another a
/// profile may say so, `chosen` or installed.
IsMine drivable_by(const DriverEntry& driver, const DeviceSheet& chosen,
                   const AttachOptions& options) {
  std::vector<DeviceSheet> sheets;
  if (!driver.traits.can_push_a_person) {
    if (options.installed) sheets = options.installed();
    sheets.push_back(chosen);
  }
  return [&driver, sheets = std::move(sheets)](const HidrawNode& node) {
    const DriverEntry* const found = driver_for(node);
    return found == &driver ||
           (found == nullptr && std::any_of(sheets.begin(), sheets.end(), [&](const auto& sheet) {
              return names_it(sheet, driver, node);
            }));
  };
}

/// Checks and limits a device that pushes.
DeviceGrant grant(const HidrawNode& node, const DeviceStatement& statement,
                  const AttachOptions& options, AttachedDevice& attached) {
  require(statement.sheet, options);
  attached.sheet = statement.sheet;
  attached.check = check_of(node, statement, options.checks);
  if (!attached.check->passed()) {
    limit(attached.sheet, &DeviceProfile::peak_force, kUncheckedForce,
          "nobody has checked its axes and signs");
    require(attached.sheet, options);
  }
  count_damping(*attached.check, attached.sheet);
  return {attached.sheet, std::min(options.max_force, attached.sheet.profile.peak_force)};
}

}  // namespace

void count_damping(const DeviceCheck& check, DeviceSheet& sheet) {
  const std::optional<DampingBounds> known = counted_damping(check.damping(), check.can_push());
  const DeviceProfile& profile = sheet.profile;
  if (!known || (!profile.damping_guessed && profile.damping <= known->upper)) return;
  state_number(sheet, &DeviceProfile::damping, {known->lower},
               {0, "measured by hapticctl device check: at least this", false});
}

AttachedDevice attach_device(const DeviceSource& source, const DeviceSheet& chosen,
                             const AttachOptions& options) {
  const DriverEntry* const driver = source.driver;
  const IsMine mine = drivable_by(*driver, chosen, options);
  const HidrawNode node = find_node(mine, source.argument, std::string(driver->kind));
  auto handles = std::make_unique<HidrawHandles>(node);
  AttachedDevice attached;
  attached.sheet = chosen;
  double force = 0.0;
  const FoundDevice found{node, handles->channel(), chosen, options.installed,
                          [&](const DeviceStatement& statement) {
                            DeviceGrant granted = grant(node, statement, options, attached);
                            force = granted.force;
                            return granted;
                          }};
  attached.open = driver->open(found);
  if (attached.check == nullptr && driver->traits.can_push_a_person) {
    throw std::logic_error("the driver " + std::string(driver->kind) + " has asked for no grant");
  }
  for (const std::string& warning : attached.open.warnings) {
    spdlog::warn("{}: {}", describe(node), warning);
  }
  if (attached.check != nullptr) {
    if (attached.sheet.profile.damping_guessed) {
      spdlog::info("{}: its damping is a guess until it is measured: hapticctl device check",
                   describe(node));
    }
    spdlog::info("{}: force limited to {} N{}", describe(node), force,
                 attached.check->passed() ? "" : " until it is checked: hapticctl device check");
  }
  attached.attachment =
      std::make_unique<Attachment>(*attached.open.plug, mine, node, std::move(handles));
  return attached;
}

}  // namespace hapticd
