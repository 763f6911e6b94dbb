from . import salience as salience
