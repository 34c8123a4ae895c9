// See profile_numbers.h.
#include "server/devices/profile_numbers.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

v1::Quantity& quantity(v1::DeviceProfile& profile, const std::string& name) {
  const google::protobuf::FieldDescriptor* field = profile.GetDescriptor()->FindFieldByName(name);
  return dynamic_cast<v1::Quantity&>(*profile.GetReflection()->MutableMessage(&profile, field));
}

}  // namespace

void fill(v1::DeviceProfile& profile, const std::string& name,
          std::initializer_list<double> values) {
  v1::Quantity& number = quantity(profile, name);
  if (number.value_size() > 0) return;
  number.mutable_value()->Add(values.begin(), values.end());
  number.set_source(kStated);
}

void limit(v1::DeviceProfile& profile, const std::string& name, double most, const char* source) {
  if (!std::isfinite(most)) return;
  v1::Quantity& number = quantity(profile, name);
  if (number.value_size() > 0 && number.value(0) <= most) return;
  number.clear_value();
  number.add_value(most);
  number.set_source(source);
  number.clear_guess();
}

CheckedProfile profile_to_check(const v1::DeviceProfile& profile) {
  return {profile.name(), checked(profile).axes};
}

LoadedProfile checked(const v1::DeviceProfile& profile) {
  ProfileResult result = check_profile(profile);
  if (result.loaded) return std::move(*result.loaded);
  throw std::runtime_error("what the device states of itself is not a valid profile: " +
                           to_text(result.problems.front()));
}

}  // namespace hapticd
