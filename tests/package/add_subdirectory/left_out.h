#pragma once

/// Asks a build without anything that can be left out for each of these. Whether every call threw what it should;
/// says on stderr which did not.
bool everything_throws();
