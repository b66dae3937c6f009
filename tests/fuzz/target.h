#pragma once
/// What libFuzzer, or driver.cpp where there is none, calls with an input; and what it has for those who change inputs
/// in ways of their own.

#include <cstddef>
#include <cstdint>

extern "C" {

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Of a target that has one: changes an input, in place, and returns its new size.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned int seed);

/// The change that there is without.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

}  // extern "C"
