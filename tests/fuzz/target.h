#pragma once
/// The entry points that libFuzzer, or driver.cpp without it, calls with an input, and the mutator of targets that have
/// their own.

#include <cstddef>
#include <cstdint>

extern "C" {

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Optional mutator of a target: changes an input, in place, and returns its new size.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned int seed);

/// The change that there is without.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

}  // extern "C"
