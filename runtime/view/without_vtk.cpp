// Stands in for vtk.cpp in a build without HDF5.

#include <atoll/error.h>

#include "view/vtk.h"

namespace atl::view {

bool has_vtk() { return false; }

VtkSeries::VtkSeries(const VtkOptions&, Sink) : clock_(0, 1) {
  throw Error("VtkSeries: this build writes no VTKHDF (ATOLL_BUILD_VTK is off)");
}

void VtkSeries::add(const World&, const StepReport&, double) {}
void VtkSeries::write_frame(const World&) {}

}  // namespace atl::view
