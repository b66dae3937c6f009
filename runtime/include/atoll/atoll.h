#pragma once
/// Atoll: a multithreaded, island-parallel rigid-body runtime. This header includes the whole public API.

#include <atoll/batch.h>
#include <atoll/body.h>
#include <atoll/body_hash.h>
#include <atoll/closed_form.h>
#include <atoll/contact_callbacks.h>
#include <atoll/contact_problem.h>
#include <atoll/error.h>
#include <atoll/error_meter.h>
#include <atoll/errors.h>
#include <atoll/forces.h>
#include <atoll/joint.h>
#include <atoll/mechanism.h>
#include <atoll/quarantine.h>
#include <atoll/queries.h>
#include <atoll/parting.h>
#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/report.h>
#include <atoll/rollout.h>
#include <atoll/scene.h>
#include <atoll/settings.h>
#include <atoll/shapes.h>
#include <atoll/snapshot.h>
#include <atoll/types.h>
#include <atoll/world.h>
