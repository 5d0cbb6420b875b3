"""Names, normalised (`members.normalise`), under which calibration programs write the parts of a camera."""


def words(names: str) -> tuple[str, ...]:
    """Split names at blanks."""
    return tuple(names.split())


def _pairs(names: str) -> tuple[tuple[str, str], ...]:
    return tuple((x, y) for x, y in (pair.split(",") for pair in names.split()))


EXPLICIT_MATRIX = ("cameramatrix", "cameramat", "cammatrix")
"""Names that nothing but a camera matrix has."""
MATRIX = (
    *EXPLICIT_MATRIX,
    *words(
        "cameramtx mtx k kmatrix matrixk intrinsicmatrix intrinsicsmatrix cameraintrinsicmatrix "
        "cameraintrinsics intrinsics intrinsic intrinsicmat intrinsicparameters calibrationmatrix "
        "cameracalibrationmatrix cameraintrinsic m a matrix"
    ),
)
DISTORTION = words(
    "distortioncoefficients distortioncoeffs distortioncoeff distortioncoefs distortioncoef "
    "distcoeffs distcoeff distcoefs distcoef distcoefficients distortioncoefficient distortion "
    "distortions dist d distortionvector distortionparameters distortionparams cameradistortion "
    "distortionmatrix lensdistortion coeffs coefficients kc distvec distortionvalues dists "
    "distortionarray distparams cameradistcoeffs"
)
COEFFICIENTS = words("k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty")
"""Coefficients that have a name each, in OpenCV's order."""
FISHEYE_COEFFICIENTS = ("k1", "k2", "k3", "k4", "k5")
FOCAL = _pairs(
    "fx,fy fu,fv gamma1,gamma2 mu,mv flx,fly focalx,focaly focallengthx,focallengthy alphax,alphay "
    "alphau,alphav au,av ax,ay focalxpx,focalypx"
)
CENTRE = _pairs(
    "cx,cy cu,cv pu,pv u0,v0 ppx,ppy px,py x0,y0 principalpointx,principalpointy centerx,centery "
    "ox,oy cenx,ceny"
)
FOCAL_PAIRS = words("focallength fc focallengths focal f focallengthpx")
CENTRE_PAIRS = words("principalpoint cc opticalcenter opticalcentre principal center c pp")
NESTED = words(
    "projectionparameters distortionparameters mirrorparameters intrinsics intrinsic camera "
    "parameters params distortion distortioncoefficients distcoeffs distortionparams lens projection "
    "cameraparameters intrinsicparameters coefficients distortioncoeffs cameraintrinsics "
    "radialdistortion tangentialdistortion radial tangential dist cameramatrix focallength "
    "principalpoint"
)
"""Members whose own members count as the camera's."""
SIDES = _pairs(
    "imagewidth,imageheight imgwidth,imgheight width,height imwidth,imheight framewidth,frameheight "
    "camerawidth,cameraheight imagesizewidth,imagesizeheight resolutionwidth,resolutionheight "
    "resolutionx,resolutiony widthpx,heightpx imagecols,imagerows imgw,imgh xres,yres resx,resy w,h "
    "nx,ny"
)
"""Width and height."""
SIZE = words(
    "imgsize imagesize resolution cameraresolution imsize imageresolution framesize calibdimension "
    "calibrationresolution imagedimensions imagesizes dimensions size resolutions viewport"
)
"""Width and height in one."""
SHAPE = ("imageshape", "imgshape", "shape", "frameshape")
"""Sizes in numpy's order, height first."""
