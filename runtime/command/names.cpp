#include "names.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace atl::command {

std::string significant(double value, int digits) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}

std::string plain(double value, int digits) {
  const double size = std::abs(value);
  const int before = size >= 1 ? static_cast<int>(std::floor(std::log10(size))) + 1 : 1;
  const double unit = std::pow(10.0, std::max(0, before - digits));
  std::ostringstream text;
  text << std::fixed << std::setprecision(std::max(0, digits - before)) << unit * std::round(value / unit);
  return text.str();
}

}  // namespace atl::command
