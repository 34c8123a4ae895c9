// See sheet_translation.h.
#include "server/scene_io/sheet_translation.h"

#include <algorithm>
#include <string>

namespace hapticd {
namespace {

namespace pb = google::protobuf;

constexpr std::string_view kAxisMap = "axis_map.";

/// The Quantity of this name, of the profile or of its axis map; null: it is not there.
const v1::Quantity* find_quantity(const v1::DeviceProfile& profile, std::string_view name) {
  const bool of_axes = name.starts_with(kAxisMap);
  const pb::Message& message =
      of_axes ? static_cast<const pb::Message&>(profile.axis_map()) : profile;
  if (of_axes) name.remove_prefix(kAxisMap.size());
  const auto* field = message.GetDescriptor()->FindFieldByName(std::string(name));
  const pb::Reflection& reflection = *message.GetReflection();
  if (!reflection.HasField(message, field)) return nullptr;
  return &dynamic_cast<const v1::Quantity&>(reflection.GetMessage(message, field));
}

v1::Quantity& make_quantity(v1::DeviceProfile& profile, std::string_view name) {
  const bool of_axes = name.starts_with(kAxisMap);
  pb::Message& message = of_axes ? static_cast<pb::Message&>(*profile.mutable_axis_map()) : profile;
  if (of_axes) name.remove_prefix(kAxisMap.size());
  const auto* field = message.GetDescriptor()->FindFieldByName(std::string(name));
  return dynamic_cast<v1::Quantity&>(*message.GetReflection()->MutableMessage(&message, field));
}

/// Odd ones are positive; each direction has two.
void take_axes(const v1::AxisMap& from, DeviceSheet& to) {
  to.axes_stated = from.axes_size() > 0;
  for (int i = 0; i < from.axes_size(); ++i) {
    const int place = from.axes(i) - v1::AXIS_POSITIVE_X;
    const auto axis = static_cast<std::size_t>(i);
    to.axes.raw_axis[axis] = static_cast<std::uint8_t>(place / 2);
    to.axes.sign[axis] = place % 2 == 0 ? 1.0 : -1.0;
  }
}

void tell_axes(const DeviceSheet& from, v1::AxisMap& to) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int sign = from.axes.sign[axis] < 0.0 ? 1 : 0;
    to.add_axes(static_cast<v1::Axis>(v1::AXIS_POSITIVE_X + 2 * from.axes.raw_axis[axis] + sign));
  }
}

DeviceMatch match_of(const v1::DeviceMatch& from) {
  DeviceMatch to;
  if (from.has_vendor_id()) to.vendor_id = from.vendor_id();
  if (from.has_product_id()) to.product_id = from.product_id();
  if (from.has_usage_page()) to.usage_page = from.usage_page();
  if (from.has_usage()) to.usage = from.usage();
  if (from.has_serial()) to.serial = from.serial();
  return to;
}

void tell_match(const DeviceMatch& from, v1::DeviceMatch& to) {
  if (from.vendor_id) to.set_vendor_id(*from.vendor_id);
  if (from.product_id) to.set_product_id(*from.product_id);
  if (from.usage_page) to.set_usage_page(*from.usage_page);
  if (from.usage) to.set_usage(*from.usage);
  if (from.serial) to.set_serial(*from.serial);
}

}  // namespace

DeviceSheet to_sheet(const v1::DeviceProfile& from) {
  DeviceSheet to;
  std::copy_n(from.name().begin(), std::min(from.name().size(), kDeviceNameCapacity),
              to.profile.name.begin());
  to.profile.driver = static_cast<DeviceDriver>(from.driver());
  to.profile.affine = from.affine();
  to.profile.force_reaches_hand = from.has_force_reaches_hand()
                                      ? from.force_reaches_hand()
                                      : from.driver() == v1::DRIVER_SCRIPTED;
  to.profile.switches_unwired = from.switches_unwired();
  to.description = from.description();
  for (const v1::DeviceMatch& match : from.matches()) to.matches.push_back(match_of(match));
  take_axes(from.axis_map(), to);
  for (const SheetRow& row : kSheetRows) {
    const v1::Quantity* quantity = find_quantity(from, row.name);
    if (quantity == nullptr) continue;
    state_number(to, row.number, {quantity->value().begin(), quantity->value().end()},
                 {0, quantity->source(), quantity->guess()});
  }
  return to;
}

v1::DeviceProfile to_profile(const DeviceSheet& from) {
  v1::DeviceProfile to;
  to.set_name(std::string(device_name(from.profile)));
  to.set_description(from.description);
  to.set_driver(static_cast<v1::Driver>(from.profile.driver));
  to.set_affine(from.profile.affine);
  const bool is_scripted = from.profile.driver == DeviceDriver::kScripted;
  if (from.profile.force_reaches_hand != is_scripted) {
    to.set_force_reaches_hand(from.profile.force_reaches_hand);
  }
  to.set_switches_unwired(from.profile.switches_unwired);
  for (const DeviceMatch& match : from.matches) tell_match(match, *to.add_matches());
  if (from.axes_stated) tell_axes(from, *to.mutable_axis_map());
  for (const SheetRow& row : kSheetRows) {
    const std::vector<double> values = stated_values(from, row.number);
    if (values.empty()) continue;
    v1::Quantity& quantity = make_quantity(to, row.name);
    quantity.mutable_value()->Add(values.begin(), values.end());
    quantity.set_source(source_of(from, row.number).text);
    quantity.set_guess(source_of(from, row.number).guess);
  }
  return to;
}

}  // namespace hapticd
