#pragma once
/// What libFuzzer, or driver.cpp where there is none, calls with an input.

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
