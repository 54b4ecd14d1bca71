// A skeleton: the roll rate of vehicle_angular_velocity is y and z, and u goes to
// vehicle_torque_setpoint. Put in the topics of your loop at the two marks. It starts and stops
// itself, since the ModuleBase of PX4 1.17 is another one than that before.
#include <string.h>

#include <drivers/drv_hrt.h>
#include <px4_platform_common/atomic.h>
#include <px4_platform_common/log.h>
#include <px4_platform_common/module_params.h>
#include <px4_platform_common/px4_work_queue/WorkItem.hpp>
#include <px4_platform_common/time.h>
#include <uORB/Publication.hpp>
#include <uORB/Subscription.hpp>
#include <uORB/SubscriptionCallback.hpp>
#include <uORB/topics/parameter_update.h>
#include <uORB/topics/vehicle_angular_velocity.h>
#include <uORB/topics/vehicle_torque_setpoint.h>

#include "rcac.h"

class Rcac : public ModuleParams, public px4::WorkItem
{
public:
	Rcac() : ModuleParams(nullptr), WorkItem(MODULE_NAME, px4::wq_configurations::rate_ctrl)
	{
		rcac_init(&_controller);
		take_parameters();
	}

	bool start()
	{
		if ((rcac_self_check() & ~16) != 0) {
			PX4_ERR("the compiler does not round as C says: -ffp-contract=off, and no fast math");
			return false;
		}

		return _rates.registerCallback();
	}

	void stop()
	{
		_should_stop.store(true);
		ScheduleNow();

		while (!_has_stopped.load()) { px4_usleep(1000); }
	}

	void print_status() const
	{
		PX4_INFO("status %d, step %lld, updates decided by rounding %lld", rcac_status(&_controller),
			 (long long)_controller.step, (long long)rcac_guard_count(&_controller));
	}

private:
	void Run() override
	{
		if (_should_stop.load()) {
			_rates.unregisterCallback();
			_has_stopped.store(true); // nothing of this object is touched after it
			return;
		}

		if (_parameter_update.updated()) {
			parameter_update_s update;
			_parameter_update.copy(&update);
			updateParams();
			take_parameters();
		}

		vehicle_angular_velocity_s rates;

		if (!_rates.update(&rates)) { return; }

		rcac_real y[RCAC_L_Y + 1] {}, z[RCAC_L_Z] {}, r[RCAC_L_R + 1] {}, u[RCAC_L_U] {};
		y[0] = z[0] = static_cast<rcac_real>(rates.xyz[0]);   // your measurements, rad/s here

		const int status = rcac_step(&_controller, y, z, r, u);

		if ((status & RCAC_DIVERGED) != 0 && (_said & RCAC_DIVERGED) == 0) {
			PX4_ERR("diverged: Phi theta is 0 from here on");
		}

		_said = status;

		vehicle_torque_setpoint_s torque{};
		torque.timestamp = hrt_absolute_time();
		torque.timestamp_sample = rates.timestamp_sample;
		torque.xyz[0] = static_cast<float>(u[0]);             // your actuators
		_torque.publish(torque);
	}

	// Where they were changed, so that what the export has planned stays.
	void take_parameters()
	{
		const int32_t adapts = _switch.get();
		const float lambda = _lambda.get();

		if (adapts != _adapts) { rcac_freeze(&_controller, adapts == 0); }

		if (lambda < _used_lambda || lambda > _used_lambda) {
			rcac_set_lambda(&_controller, static_cast<rcac_real>(lambda));
		}

		_adapts = adapts;
		_used_lambda = lambda;
	}

	rcac_state _controller;
	int _said{0};
	int32_t _adapts{1};
	float _used_lambda{@LAMBDA@};
	px4::atomic_bool _should_stop{false}, _has_stopped{false};
	uORB::SubscriptionCallbackWorkItem _rates{this, ORB_ID(vehicle_angular_velocity)};
	uORB::Subscription _parameter_update{ORB_ID(parameter_update)};
	uORB::Publication<vehicle_torque_setpoint_s> _torque{ORB_ID(vehicle_torque_setpoint)};
	DEFINE_PARAMETERS(
		(ParamInt<px4::params::RCAC_SW>) _switch,
		(ParamFloat<px4::params::RCAC_LAMBDA>) _lambda
	)
};

static Rcac *module = nullptr;

extern "C" __EXPORT int rcac_main(int argc, char *argv[])
{
	const char *command = argc > 1 ? argv[1] : "";

	if (strcmp(command, "start") == 0) {
		if (module != nullptr) { return 0; }

		module = new Rcac();

		if (module != nullptr && module->start()) { return 0; }

		delete module;
		module = nullptr;
		return 1;
	}

	if (strcmp(command, "stop") == 0 || strcmp(command, "status") == 0) {
		if (module == nullptr) {
			PX4_INFO("not running");
			return 0;
		}

		if (strcmp(command, "status") == 0) {
			module->print_status();

		} else {
			module->stop();
			delete module;
			module = nullptr;
		}

		return 0;
	}

	PX4_INFO("usage: rcac {start|stop|status}");
	return 1;
}
