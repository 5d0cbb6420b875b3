% Intrinsic and Extrinsic Camera Parameters

%-- Focal length:
fc = [ 900.0 ; 905.0 ];
cc = [ 630.0 ; 350.0 ];
alpha_c = 0.000;
kc = [ -0.2 ; 0.05 ; 0.001 ; -0.001 ; 0.01 ];
nx = 1280;
ny = 720;
