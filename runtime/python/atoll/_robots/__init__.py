"""Robot models of other formats as scenes, with a receipt of what became of each of their elements."""

from .mjcf import load_mjcf as load_mjcf
from .receipt import Line as Line, Receipt as Receipt, Verdict as Verdict
from .robot import Actuator as Actuator, Coordinate as Coordinate, Robot as Robot
from .sensors import Sensor as Sensor
from .urdf import load_urdf as load_urdf
