// A skeleton: the roll rate of vehicle_angular_velocity is y and z, and u goes to
// vehicle_torque_setpoint. Put in the topics of your loop at the two marks.
#include <px4_platform_common/module.h>
#include <px4_platform_common/module_params.h>
#include <px4_platform_common/px4_work_queue/WorkItem.hpp>
#include <uORB/Publication.hpp>
#include <uORB/Subscription.hpp>
#include <uORB/SubscriptionCallback.hpp>
#include <uORB/topics/parameter_update.h>
#include <uORB/topics/vehicle_angular_velocity.h>
#include <uORB/topics/vehicle_torque_setpoint.h>

#include "rcac.h"

class Rcac : public ModuleBase<Rcac>, public ModuleParams, public px4::WorkItem
{
public:
	Rcac() : ModuleParams(nullptr), WorkItem(MODULE_NAME, px4::wq_configurations::rate_ctrl)
	{
		rcac_init(&_controller);
		take_parameters();
	}

	bool init()
	{
		if ((rcac_self_check() & ~16) != 0) {
			PX4_ERR("the compiler does not round as C says");
			return false;
		}

		return _rates.registerCallback();
	}

	static int task_spawn(int, char *[])
	{
		Rcac *instance = new Rcac();

		if (instance == nullptr) { return PX4_ERROR; }

		_object.store(instance);
		_task_id = task_id_is_work_queue;

		if (instance->init()) { return PX4_OK; }

		delete instance;
		_object.store(nullptr);
		_task_id = -1;
		return PX4_ERROR;
	}

	static int custom_command(int, char *[]) { return print_usage("unknown command"); }

	static int print_usage(const char *reason = nullptr)
	{
		if (reason != nullptr) { PX4_WARN("%s", reason); }

		PRINT_MODULE_USAGE_NAME("rcac", "controller");
		PRINT_MODULE_USAGE_COMMAND("start");
		PRINT_MODULE_USAGE_DEFAULT_COMMANDS();
		return 0;
	}

	int print_status() override
	{
		PX4_INFO("status %d, step %lld, updates decided by rounding %lld", rcac_status(&_controller),
			 (long long)_controller.step, (long long)rcac_guard_count(&_controller));
		return 0;
	}

private:
	void Run() override
	{
		if (should_exit()) {
			_rates.unregisterCallback();
			exit_and_cleanup();
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

		if ((rcac_step(&_controller, y, z, r, u) & RCAC_DIVERGED) != 0) {
			PX4_ERR("diverged: Phi theta is 0 from here on");
		}

		vehicle_torque_setpoint_s torque{};
		torque.timestamp = hrt_absolute_time();
		torque.timestamp_sample = rates.timestamp_sample;
		torque.xyz[0] = static_cast<float>(u[0]);             // your actuators
		_torque.publish(torque);
	}

	void take_parameters()
	{
		rcac_freeze(&_controller, _switch.get() ? 0 : 1);
		rcac_set_lambda(&_controller, static_cast<rcac_real>(_lambda.get()));
	}

	rcac_state _controller;
	uORB::SubscriptionCallbackWorkItem _rates{this, ORB_ID(vehicle_angular_velocity)};
	uORB::Subscription _parameter_update{ORB_ID(parameter_update)};
	uORB::Publication<vehicle_torque_setpoint_s> _torque{ORB_ID(vehicle_torque_setpoint)};
	DEFINE_PARAMETERS(
		(ParamInt<px4::params::RCAC_SW>) _switch,
		(ParamFloat<px4::params::RCAC_LAMBDA>) _lambda
	)
};

extern "C" __EXPORT int rcac_main(int argc, char *argv[]) { return Rcac::main(argc, argv); }
