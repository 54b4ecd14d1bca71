// Reads A0, writes a PWM pin, every 10 ms.
#include <rcac.h>

static_assert(sizeof(rcac_real) == (RCAC_FLOAT32 ? 4 : 8),
              "double has 4 bytes on this board: export with --real float32");

const int sensor = A0, actuator = 9;
const unsigned long period_us = 10000;
rcac_state controller;
unsigned long next_us;

void setup() {
  Serial.begin(115200);
  if (rcac_self_check() & ~16) {
    Serial.println("the compiler does not round as C says");
    for (;;) {
    }
  }
  rcac_init(&controller);
  next_us = micros();
}

void loop() {
  if ((long)(micros() - next_us) < 0) return;
  next_us += period_us;
  rcac_real y[RCAC_L_Y + 1] = {0}, z[RCAC_L_Z] = {0}, r[RCAC_L_R + 1] = {0}, u[RCAC_L_U];
  y[0] = z[0] = (rcac_real)analogRead(sensor) / 512 - 1;  // volts or metres: as in the settings
  const int status = rcac_step(&controller, y, z, r, u);
  analogWrite(actuator, constrain((int)(u[0] * 127) + 128, 0, 255));
  if (status != RCAC_OK) Serial.println(status);
}
