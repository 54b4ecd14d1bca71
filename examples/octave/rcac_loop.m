% Example 4.7 by a small RCAC loop of its own: plain covariance form, (2.42)-(2.45), in Octave.
%
%   octave-cli --no-gui rcac_loop.m        writes rcac_loop.mat
%
% Nothing of this project is used here, so that `rcac check rcac_loop.mat` looks at a log that
% another program wrote. Row k + 1 of every array belongs to step k; u(k) = phi(k) theta(k).

N = [1, -1.44, 0.81];                                 % G = N / D, y = z, w adds to u
D = conv([1, -0.9], [1, -1.71, 0.903]);
D_p = conv([1, 0, -0.25], [1, 0, 0.64]);              % poles 1/2, -1/2, 0.8j, -0.8j
n_c = 4; k_w = 50; R_theta = 1e-6; steps = 300;

w = ones(steps, 1);
u = zeros(steps, 1); y = zeros(steps, 1); z = zeros(steps, 1);
theta = zeros(steps, 2 * n_c);
P = eye(2 * n_c) / R_theta;
now = zeros(2 * n_c, 1);                              % theta(k)

function value = past(x, k, i)
  if k - i >= 1, value = x(k - i); else, value = 0; end
end

phi_f = zeros(steps, 2 * n_c);                        % G_f = q^-1 / (D_p q^-4), on u and on phi
u_f = zeros(steps, 1);
phi = zeros(steps, 2 * n_c);
v = zeros(steps, 1);                                  % u + w, what drives the plant
for k = 1:steps
  for i = 1:3
    y(k) -= D(i + 1) * past(y, k, i);
    y(k) += N(i) * past(v, k, i);
  end
  z(k) = y(k);
  for i = 1:n_c
    phi(k, i) = past(u, k, i);
    phi(k, n_c + i) = past(y, k, i);
  end
  theta(k, :) = now';
  if k - 1 >= k_w
    u(k) = phi(k, :) * now;
  end
  v(k) = u(k) + w(k);

  if k > 1
    phi_f(k, :) = phi(k - 1, :);
    u_f(k) = u(k - 1);
  end
  for i = 1:4
    if k - i >= 1
      phi_f(k, :) -= D_p(i + 1) * phi_f(k - i, :);
      u_f(k) -= D_p(i + 1) * u_f(k - i);
    end
  end
  if k - 1 >= k_w
    f = phi_f(k, :)';
    P -= (P * f) * (f' * P) / (1 + f' * P * f);
    now -= P * f * (z(k) - u_f(k) + f' * now);        % zhat = z + Phi_f theta - u_f
  end
end

program = ['GNU Octave ', version()];
save('-v7', 'rcac_loop.mat', 'u', 'y', 'z', 'w', 'theta', 'program');
